//! Memory asked for before it is needed.

/// Asks for the cache line in which something begins, where there is such a thing, and does not wait for it.
///
/// A plain read would do as much for the caches, but keeps all later instructions waiting in the processor
/// when it takes long. Where no such instruction is known nothing is asked for.
#[inline(always)]
pub(crate) fn fetch<T>(place: Option<&T>) {
    #[cfg(target_arch = "x86_64")]
    if let Some(place) = place {
        safe_arch::prefetch_t0(place);
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
