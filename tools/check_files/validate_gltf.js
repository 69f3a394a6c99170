// Khronos's validator over the files named: no error, no warning.
const fs = require("fs");
const validator = require("gltf-validator");

async function main(files) {
  let bad = 0;
  for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    const { numErrors, numWarnings, messages } = report.issues;
    if (numErrors + numWarnings > 0) {
      bad += 1;
      console.error(file, JSON.stringify(messages.filter((m) => m.severity < 2).slice(0, 5), null, 1));
    }
  }
  process.exitCode = bad ? 1 : 0;
}

main(process.argv.slice(2));
