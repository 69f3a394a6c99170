//! A camera with perspective.

use glam::{Vec2, Vec3A};

/// Where the picture is taken from: an eye, three axes, and an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub(super) eye: Vec3A,
    pub(super) forward: Vec3A,
    pub(super) right: Vec3A,
    pub(super) above: Vec3A,
    /// Tangent of half the opening, bottom to top.
    pub(super) half_height: f32,
}

/// Tangent of half the opening of [`Camera::best_view`]: 30° in all, as a portrait lens. tan 15° = 2 − √3.
pub(super) const PORTRAIT: f32 = 0.267_949_2;

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` upwards in the picture; `half_height`
    /// is the tangent of half the angle from the bottom to the top of the picture.
    ///
    /// # Panics
    /// When a number is not finite, or the angle not positive.
    pub fn look_at(eye: [f32; 3], target: [f32; 3], up: [f32; 3], half_height: f32) -> Self {
        let places = [eye, target, up];
        assert!(
            places.as_flattened().iter().all(|x| x.is_finite()),
            "a camera at {eye:?} that looks at {target:?}, with {up:?} upwards"
        );
        assert!(
            half_height.is_finite() && half_height > 0.0,
            "an opening of {half_height}"
        );
        let [eye, target, up] = [eye, target, up].map(Vec3A::from_array);
        Self::along(eye, target - eye, up, half_height)
    }

    pub(super) fn along(eye: Vec3A, forward: Vec3A, up: Vec3A, half_height: f32) -> Self {
        let forward = forward.try_normalize().unwrap_or(Vec3A::NEG_Z);
        let right = forward
            .cross(up)
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        Self {
            eye,
            forward,
            right,
            above: right.cross(forward),
            half_height,
        }
    }

    /// Where the camera is.
    pub fn eye(&self) -> [f32; 3] {
        self.eye.to_array()
    }

    /// The unit direction in which it looks.
    pub fn forward(&self) -> [f32; 3] {
        self.forward.to_array()
    }

    /// The unit direction that is upwards in the picture.
    pub fn above(&self) -> [f32; 3] {
        self.above.to_array()
    }

    /// The angle from the bottom to the top of the picture, degrees.
    pub fn opening(&self) -> f32 {
        2.0 * libm::atanf(self.half_height).to_degrees()
    }

    /// How far a point is in front of the eye, along [`Camera::forward`].
    pub fn depth(&self, point: [f32; 3]) -> f32 {
        (Vec3A::from_array(point) - self.eye).dot(self.forward)
    }

    /// By another a picture would be taken for ever.
    pub(super) fn assert_finite(&self) {
        let axes = [self.eye, self.forward, self.right, self.above];
        let is_finite = axes.iter().all(|v| v.is_finite()) && self.half_height.is_finite();
        assert!(is_finite, "a camera whose numbers are not finite: {self:?}");
    }

    /// This camera, brought nearer: what is at this depth in the middle is `factor` times as large.
    #[must_use]
    pub fn zoomed(&self, depth: f32, factor: f32) -> Self {
        Self {
            eye: self.eye + self.forward * (depth * (1.0 - 1.0 / factor)),
            ..*self
        }
    }

    /// This camera, moved sideways until a point is within this share of the way from the picture's middle
    /// to its edges, for pictures of this width over height.
    ///
    /// # Panics
    /// When `aspect` or `share` is negative or no number.
    #[must_use]
    pub fn centred(&self, point: [f32; 3], aspect: f32, share: f32) -> Self {
        let v = Vec3A::from_array(point) - self.eye;
        let most = share * self.half_height * v.dot(self.forward).max(0.0);
        assert!(
            most >= 0.0 && most * aspect >= 0.0,
            "{point:?} within {share} of the way to edges of aspect {aspect}"
        );
        let over = |x: f32, most: f32| x - x.clamp(-most, most);
        let [x, y] = [
            over(v.dot(self.right), most * aspect),
            over(v.dot(self.above), most),
        ];
        Self {
            eye: self.eye + self.right * x + self.above * y,
            ..*self
        }
    }

    /// How wide the picture is at this depth, for pictures of this width over height.
    pub fn width_at(&self, depth: f32, aspect: f32) -> f32 {
        2.0 * depth * self.half_height * aspect
    }

    /// Where a point falls in a picture of this width over height: x from the left and y from the
    /// top, both 0 to 1 inside the picture. None for what is behind the eye.
    pub fn project(&self, point: [f32; 3], aspect: f32) -> Option<[f32; 2]> {
        let v = Vec3A::from_array(point) - self.eye;
        let depth = v.dot(self.forward);
        let x = v.dot(self.right) / (depth * self.half_height * aspect);
        let y = v.dot(self.above) / (depth * self.half_height);
        (depth > 0.0).then_some([0.5 + 0.5 * x, 0.5 - 0.5 * y])
    }

    /// The same of what is inside the picture.
    pub fn frames(&self, point: [f32; 3], aspect: f32) -> Option<[f32; 2]> {
        let place = self.project(point, aspect)?;
        place
            .iter()
            .all(|x| (0.0..=1.0).contains(x))
            .then_some(place)
    }

    /// The unit direction through a place of the picture, as [`Camera::project`] counts it.
    pub(super) fn direction(&self, place: Vec2, aspect: f32) -> Vec3A {
        let x = (2.0 * place.x - 1.0) * self.half_height * aspect;
        let y = (1.0 - 2.0 * place.y) * self.half_height;
        (self.forward + self.right * x + self.above * y).normalize()
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::super::{Scene, Settings, Stone, World, render};
    use super::Camera;

    #[test]
    #[should_panic(expected = "a camera at")]
    fn a_camera_that_is_nowhere_is_refused() {
        Camera::look_at([f32::NAN, 0.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0], 0.3);
    }

    fn triangle() -> Stone {
        Stone::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], &[[0, 1, 2]])
    }

    #[test]
    fn pictures_without_a_width_or_a_height_have_no_view() {
        let stone = triangle();
        let world = World::new(&Scene::bare(&stone, [0.0, 1.0, 0.0]));
        for aspect in [0.0, -1.0, f32::INFINITY, f32::NAN] {
            let best = || Camera::best_view(&world, aspect);
            assert!(catch_unwind(AssertUnwindSafe(best)).is_err(), "{aspect}");
            let side = || Camera::from_side(&world, aspect, 0.0, 0.0);
            assert!(catch_unwind(AssertUnwindSafe(side)).is_err(), "{aspect}");
        }
        let nowhere = || Camera::from_side(&world, 1.0, f32::NAN, 0.0);
        assert!(catch_unwind(AssertUnwindSafe(nowhere)).is_err());
    }

    /// It took no picture for ever.
    #[test]
    #[should_panic(expected = "not finite")]
    fn a_camera_that_was_moved_to_nowhere_takes_no_picture() {
        let stone = triangle();
        let world = World::new(&Scene::bare(&stone, [0.0, 1.0, 0.0]));
        let camera = Camera::best_view(&world, 1.0).zoomed(1.0, 0.0);
        render(&world, &camera, &Settings::default());
    }
}
