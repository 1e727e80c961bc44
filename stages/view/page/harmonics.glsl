// Real spherical harmonics up to degree 3 (core/math/spherical_harmonics.h), and tables of coefficients: 16 texels a surfel, bytes
// about 128.
precision highp float;
precision highp int;
precision highp sampler2D;

void basis(vec3 d, out float y[16]) {
  float x = d.x, u = d.y, z = d.z, xx = x * x, yy = u * u, zz = z * z;
  y[0] = 0.28209479177387814;
  y[1] = -0.4886025119029199 * u, y[2] = 0.4886025119029199 * z, y[3] = -0.4886025119029199 * x;
  y[4] = 1.0925484305920792 * x * u, y[5] = -1.0925484305920792 * u * z, y[6] = 0.31539156525252005 * (2.0 * zz - xx - yy);
  y[7] = -1.0925484305920792 * x * z, y[8] = 0.5462742152960396 * (xx - yy);
  y[9] = -0.5900435899266435 * u * (3.0 * xx - yy), y[10] = 2.890611442640554 * x * u * z;
  y[11] = -0.4570457994644658 * u * (4.0 * zz - xx - yy), y[12] = 0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy);
  y[13] = -0.4570457994644658 * x * (4.0 * zz - xx - yy), y[14] = 1.445305721320277 * z * (xx - yy);
  y[15] = -0.5900435899266435 * x * (xx - 3.0 * yy);
}
vec3 coefficient(sampler2D table, int i, int k, float one) {
  int width = textureSize(table, 0).x, at = 16 * i + k;
  return (texelFetch(table, ivec2(at % width, at / width), 0).rgb * 255.0 - 128.0) / one;
}

