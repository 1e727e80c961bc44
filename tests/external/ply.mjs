// node ply.mjs FILE.ply: three's reader of PLY files on one of ours with materials. Prints JSON: how many vertices there are, and of the first
// one its normal, f_dc and roughness.
import { readFileSync } from 'node:fs';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';

const loader = new PLYLoader();
loader.setCustomPropertyNameMapping({ f_dc: ['f_dc_0', 'f_dc_1', 'f_dc_2'], roughness: ['roughness'] });
const bytes = readFileSync(process.argv[2]);
const { attributes } = loader.parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const first = (name) => [...attributes[name].array.slice(0, attributes[name].itemSize)];
console.log(JSON.stringify({ vertices: attributes.position.count, normal: first('normal'), f_dc: first('f_dc'), roughness: first('roughness')[0] }));
