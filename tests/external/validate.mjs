// node validate.mjs FILE.glb: the Khronos validator. Prints its findings; exit code 1 when there are errors.
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const report = await validator.validateBytes(new Uint8Array(readFileSync(process.argv[2])), { maxIssues: 20 });
const { numErrors, numWarnings, numInfos, messages } = report.issues;
console.log(JSON.stringify({ errors: numErrors, warnings: numWarnings, infos: numInfos, extensions: report.info.extensionsUsed }));
for (const m of messages) console.log(m.severity, m.code, m.pointer ?? '', m.message);
process.exit(numErrors > 0 ? 1 : 0);
