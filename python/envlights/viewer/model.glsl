// Rays against the triangles of a model, by a bounding volume hierarchy with skip links: no stack.
// Positions are steps of a grid of 16 bits, so the sides of triangles are exact.
uniform highp usampler2D modelNodes, modelTriangles, modelCorners;
uniform int modelNodeCount;
uniform vec4 modelGrid;       // lower corner of the grid at the origin of the floor, and its step in metres
uniform vec2 modelAt, modelTurn;  // place on the floor; cosine and sine of the turn about +y
uniform int frame;            // number of this picture of the mean, from 0

struct Hit { float t; int triangle; vec2 weights; };
const float FAR = 1e30;

ivec2 texel(int row) { return ivec2(row & 2047, row >> 11); }
vec3 toModel(vec3 d) { return vec3(modelTurn.x * d.x - modelTurn.y * d.z, d.y, modelTurn.y * d.x + modelTurn.x * d.z); }
vec3 fromModel(vec3 d) { return vec3(modelTurn.x * d.x + modelTurn.y * d.z, d.y, -modelTurn.y * d.x + modelTurn.x * d.z); }
vec3 toGrid(vec3 x) { return (toModel(x - vec3(modelAt.x, 0, modelAt.y)) - modelGrid.xyz) / modelGrid.w; }
vec3 fromGrid(vec3 q) { return fromModel(q * modelGrid.w + modelGrid.xyz) + vec3(modelAt.x, 0, modelAt.y); }

uvec3 cornersOf(int triangle) {
  uvec2 c = texelFetch(modelTriangles, texel(triangle), 0).xy;
  return uvec3(c.x & 0x1fffffu, c.x >> 21 | (c.y & 0x3ffu) << 11, c.y >> 10);
}
uvec4 corner(uint row) { return texelFetch(modelCorners, texel(int(row)), 0); }
vec3 place(uvec4 c) { return vec3(c.x & 0xffffu, c.x >> 16, c.y & 0xffffu); }
vec3 normalOf(uvec4 c) {
  vec2 p = vec2(c.y >> 16, c.z & 0xffffu) / 32767.5 - 1.0;
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(p.yx)) * mix(vec2(1), vec2(-1), lessThan(p, vec2(0)));
  return normalize(n);
}
vec3 albedoOf(uvec4 c) {
  vec3 code = vec3(c.z >> 16 & 0xffu, c.z >> 24, c.w & 0xffu) / 255.0;
  return mix(code / 12.92, pow((code + 0.055) / 1.055, vec3(2.4)), greaterThan(code, vec3(0.04045)));
}

// Nearest hit before `most`, or any if `first`; its length is in steps of the grid.
Hit traceGrid(vec3 o, vec3 d, float most, bool first) {
  Hit hit = Hit(most, -1, vec2(0));
  d = mix(d, vec3(1e-12), lessThan(abs(d), vec3(1e-12)));
  vec3 by = 1.0 / d;
  for (int node = 0; node < modelNodeCount;) {
    uvec4 box = texelFetch(modelNodes, texel(node), 0);
    // Enlarge the box by half a step, for the rounding of the ray.
    vec3 lower = vec3(box.x & 0xffffu, box.x >> 16, box.y & 0xffffu) - 0.5 - o;
    vec3 upper = vec3(box.y >> 16, box.z & 0xffffu, box.z >> 16) + 0.5 - o;
    vec3 s = lower * by, e = upper * by, near = min(s, e), far = max(s, e);
    float enter = max(max(near.x, near.y), near.z), leave = min(min(far.x, far.y), far.z);
    bool met = enter <= leave && leave >= 0.0 && enter <= hit.t, leaf = box.w >= 0x80000000u;
    node = met || leaf ? node + 1 : int(box.w);
    if (!met || !leaf) continue;
    int start = int(box.w & 0x7ffffffu), end = start + int(box.w >> 27 & 15u);
    for (int k = start; k <= end; k++) {
      // Möller and Trumbore 1997.
      uvec3 rows = cornersOf(k);
      vec3 a = place(corner(rows.x)), one = place(corner(rows.y)) - a, two = place(corner(rows.z)) - a;
      vec3 p = cross(d, two), away = o - a, q = cross(away, one);
      float det = dot(one, p);
      if (det == 0.0) continue;
      float u = dot(away, p) / det, v = dot(d, q) / det, t = dot(two, q) / det;
      if (u < -1e-6 || v < -1e-6 || u + v > 1.000001 || t <= 0.0 || t >= hit.t) continue;
      hit = Hit(t, k, vec2(u, v));
      if (first) return hit;
    }
  }
  return hit;
}

// The same from a point of the scene; the length is in metres.
Hit trace(vec3 x, vec3 d, bool first) {
  vec3 o = toGrid(x), e = toModel(d);
  // Begin near the model, where steps of the grid are not lost to rounding.
  float start = max(dot(vec3(32767.5) - o, e) - 57000.0, 0.0);
  Hit hit = traceGrid(o + start * e, e, FAR, first);
  hit.t = (start + hit.t) * modelGrid.w;
  return hit;
}

bool modelBlocks(vec3 x, vec3 d) { return trace(x, d, true).triangle >= 0; }

struct Surface { vec3 x, n, albedo; };  // point from which rays may start; smooth normal on the side of the eye

Surface surfaceOf(Hit hit, vec3 d) {
  uvec3 rows = cornersOf(hit.triangle);
  uvec4 a = corner(rows.x), b = corner(rows.y), c = corner(rows.z);
  vec3 w = vec3(1.0 - hit.weights.x - hit.weights.y, hit.weights), p = place(a), q = place(b), r = place(c);
  vec3 face = fromModel(normalize(cross(q - p, r - p))), x = mat3(p, q, r) * w;
  vec3 na = normalOf(a), nb = normalOf(b), nc = normalOf(c);
  float side = dot(face, d) > 0.0 ? -1.0 : 1.0;
  // Move the start of rays to the smooth surface (Hanika 2021, "Hacking the shadow terminator").
  vec3 smoothed = vec3(0);
  smoothed += w.x * min(side * dot(x - p, na), 0.0) * na * side;
  smoothed += w.y * min(side * dot(x - q, nb), 0.0) * nb * side;
  smoothed += w.z * min(side * dot(x - r, nc), 0.0) * nc * side;
  vec3 n = fromModel(normalize(mat3(na, nb, nc) * w)) * side;
  float off = 4.0 + 1e-6 / modelGrid.w;
  return Surface(fromGrid(x - smoothed) + off * modelGrid.w * side * face, n, mat3(albedoOf(a), albedoOf(b), albedoOf(c)) * w);
}

// Points of a square that fill it evenly over the frames, another sequence for each pixel and `dimension`:
// Sobol points with the scrambling of Burley 2020, "Practical hash-based Owen scrambling".
uint mixBits(uint x) { x ^= x >> 16; x *= 0x7feb352du; x ^= x >> 15; x *= 0x846ca68bu; return x ^ x >> 16; }
uint reversed(uint x) {
  x = x >> 16 | x << 16;
  x = (x & 0x00ff00ffu) << 8 | (x & 0xff00ff00u) >> 8;
  x = (x & 0x0f0f0f0fu) << 4 | (x & 0xf0f0f0f0u) >> 4;
  x = (x & 0x33333333u) << 2 | (x & 0xccccccccu) >> 2;
  return (x & 0x55555555u) << 1 | (x & 0xaaaaaaaau) >> 1;
}
uint scrambled(uint x, uint seed) {  // Laine and Karras 2011, on reversed bits
  x += seed; x ^= x * 0x6c50b47cu; x ^= x * 0xb82f1e52u; x ^= x * 0xc7afe638u; x ^= x * 0x8d22f6e6u;
  return x;
}
vec2 random(uint dimension) {
  uvec2 pixel = uvec2(gl_FragCoord.xy);
  uint seed = mixBits(pixel.x + mixBits(pixel.y + mixBits(dimension)));
  uint row = reversed(scrambled(reversed(uint(frame)), seed)), second = row;
  // Second Sobol dimension: the bits of Pascal's triangle.
  second ^= second >> 16; second ^= second >> 8 & 0x00ff00ffu; second ^= second >> 4 & 0x0f0f0f0fu;
  second ^= second >> 2 & 0x33333333u; second ^= second >> 1 & 0x55555555u;
  uint u = reversed(scrambled(row, mixBits(seed + 1u))), v = reversed(scrambled(second, mixBits(seed + 2u)));
  return vec2(u >> 8, v >> 8) / 16777216.0;
}
