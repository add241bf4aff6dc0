#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
//LIGHT
//CHOICES
// shadows: 0 none, 1 the paper's overlays, 2 exact; soft: some lights are discs; harmonic: the ambient term;
// glossy: the highlight; floats: radiance instead of codes; task: 0 the picture, 1 a table of hidden shares, 2 probes
uniform vec2 size, jitter, origin;
uniform vec3 eye;
uniform mat3 camera;
uniform float tanX, exposure, white, cameraHeight, dome, shine, exponent;
uniform sampler2D map, points, normals;
uniform int lights, only, column;
uniform bool flatFloor, bare, overFloor;
uniform vec3 ambient[9], direction[8], strength[8], floorAlbedo, albedo[2];
uniform vec2 radius[8];                    // sine and cosine of the angular radius
uniform vec4 ball;                         // centre and radius
uniform vec3 boxCentre, boxHalf;
uniform vec2 boxTurn;                      // cosine and sine
out vec4 colour;

const int FLOOR = 0, BALL = 1, BOX = 2, MODEL = 3, SKY = 4;
//MODEL
// Tilt below the horizon of the ray that finds the floor point of a thing, and sine and cosine of the least radius of
// the lights there; see src/kernels/occluder/reflection.rs.
const float TILT = 0.45;
const vec2 BLUR = vec2(0.3428978, 0.9393727);
// Corners of the silhouette of a box by the side of each pair of planes on which the point lies: their number, and
// three bits for each. Bit k of a corner is its sign along the axis k.
const int SILHOUETTE[27] = int[27](1467598, 629510, 654086, 1254982, 9796, 653894, 1275462, 751174, 752198, 445574, 6916,
  391942, 19588, 0, 16204, 1275526, 28372, 880462, 457862, 457990, 392454, 1244294, 24484, 1042766, 1242758, 1728214, 878926);

vec3 toBox(vec3 d) { return vec3(boxTurn.x * d.x - boxTurn.y * d.z, d.y, boxTurn.y * d.x + boxTurn.x * d.z); }
vec3 fromBox(vec3 d) { return vec3(boxTurn.x * d.x + boxTurn.y * d.z, d.y, -boxTurn.y * d.x + boxTurn.x * d.z); }

// Corner of the silhouette of the box, from the point.
vec3 corner(int k) {
  int bits = silhouette >> (3 * k);
  return fromBox(boxHalf * (2.0 * vec3(bits & 1, bits >> 1 & 1, bits >> 2 & 1) - 1.0)) - above;
}

bool has(int thing) { return only == 0 || only == thing; }

float hitBall(vec3 o, vec3 d) {
  vec3 m = o - ball.xyz;
  float b = dot(m, d), c = dot(m, m) - ball.w * ball.w, k = b * b - c;
  return k < 0.0 || !has(BALL) ? -1.0 : -b - sqrt(k);
}

float hitBox(vec3 o, vec3 d, out vec3 n) {
  vec3 q = toBox(o - boxCentre), e = toBox(d), s = mix(vec3(-1), vec3(1), greaterThan(e, vec3(0)));
  vec3 near = (-s * boxHalf - q) / e, far = (s * boxHalf - q) / e;
  float t = max(max(near.x, near.y), near.z), u = min(min(far.x, far.y), far.z);
  n = fromBox(near.x == t ? vec3(-s.x, 0, 0) : near.y == t ? vec3(0, -s.y, 0) : vec3(0, 0, -s.z));
  return t > u || !has(BOX) ? -1.0 : t;
}

bool blocked(vec3 x, vec3 d, int self) {
  vec3 n;
  return (self != BALL && hitBall(x, d) > 0.0) || (self != BOX && hitBox(x, d, n) > 0.0);
}

bool seesBall, seesBox, inside;
Cap around;                                // of the box

// Take the ball and the box as seen from a point.
void look(vec3 x, int self) {
  vec3 c = ball.xyz - x;
  float d = length(c), r = min(ball.w, d);
  seesBall = self != BALL && has(BALL);
  sphere = Cap(c / d, r / d, max(sqrt((d - r) * (d + r)) / d, 1e-3));
  vec3 q = toBox(x - boxCentre);
  ivec3 code = ivec3(greaterThan(q, boxHalf)) - ivec3(lessThan(q, -boxHalf)) + 1;
  int loop = SILHOUETTE[code.x + 3 * code.y + 9 * code.z];
  seesBox = self != BOX && has(BOX);
  sides = seesBox ? loop & 7 : 0;
  inside = seesBox && sides == 0;
  vec3 e = boxCentre - x;
  float f = length(e), s = min(length(boxHalf) / f, 1.0);
  around = Cap(e / f, s, sqrt(1.0 - s * s));
  silhouette = loop >> 3;
  apart = false;
  above = -e;
}

float factorBall, factorBox;               // form factors, of the last call of hidden(FACTORS, ...)
const int FACTORS = -2, AMBIENT = -1;

float openShare(int j, vec3 n) {
  if (j == AMBIENT) return overFloor ? 0.5 + 0.5 * n.y : 1.0;
  float c = dot(n, direction[j]);
  return soft && light.sine > 0.0 ? discShare(c, light) : max(c, 0.0);
}

// Share of light j, or of the ambient term, that ball and box hide: over that at normal incidence, or of a whole sphere.
float hidden(int j, vec3 n, int self) {
  bool sky = j < 0, cutY = j == AMBIENT && overFloor && self != FLOOR;
  float whole = sky ? PI : PI * light.sine * light.sine, sum = 0.0;
  // A thing stands above the floor, whose horizon it touches: rounding must not cut it there.
  bool low = self != FLOOR && (sky || dot(n, light.axis) < light.sine);
  bool nearBall = seesBall && (sky || meet(sphere, light)), nearBox = sides > 0 && (sky || meet(around, light));
  bool both = nearBall && nearBox && j != FACTORS && meet(sphere, around);
  bool lune = nearBall && low && (sky ? cutY && n.y < 0.9999 : dot(n, sphere.axis) < sphere.sine);
  vec3 y = cutY ? UP : vec3(0), chord = normalize(divide(light, sphere) + 1e-12);
  WHEN(nearBall && !lune && sky) sum += PI * sphere.sine * sphere.sine * discShare(dot(n, sphere.axis), sphere);
  WHEN(nearBall && !lune && !sky) sum += lens(n, light, sphere);
  if (sky) { factorBall = sum / PI; factorBox = 0.0; }
  WHEN(nearBox && !low) {
    float area = outline(n, light, !sky);
    if (sky) factorBox = area / PI;
    sum += area;
  }
  // The box over a horizon; then, as a part of the light and one of the ball, what both hide, or the ball over a horizon.
  both = both && !apart;
  // The part of the ball is not needed, and only rounding, if its rim is straight over a sun that it covers.
  bool noRim = !sky && dot(chord, sphere.axis) > 0.999998 * sphere.sine;
  for (int part = nearBox && low ? 0 : sky ? 2 : 1; part < (!lune && !both ? 1 : noRim ? 2 : 3); part += sky ? 2 : 1) {
    bool ofBox = part == 0, ofBall = part == 2;
    vec3 cut1 = ofBox ? n : sky ? y : ofBall ? -chord : chord;
    Cap cap = light;
    if (ofBall) cap = sphere;
    float area = region(n, cap, !(sky && ofBox), lune && !ofBox, cut1, ofBox ? y : vec3(0));
    if (sky && ofBox) factorBox = area / PI;
    sum += both ? -area : area;
  }
  return clamp(inside ? whole : sum, 0.0, whole) / whole;
}

// Set the light j, which is `least` wide at least.
void take(int j, vec2 least) {
  vec2 r = radius[j].x > least.x ? radius[j] : least;
  light = Cap(direction[j], r.x, r.y);
}

// Irradiance of the ambient term with nothing in the way.
vec3 sky(vec3 n) {
  if (!harmonic) return PI * ambient[0] * openShare(AMBIENT, n);
  vec3 e = ambient[0] + ambient[1] * n.y + ambient[2] * n.z + ambient[3] * n.x + ambient[4] * n.x * n.y + ambient[5] * n.y * n.z;
  return max(e + ambient[6] * (3.0 * n.z * n.z - 1.0) + ambient[7] * n.x * n.z + ambient[8] * (n.x * n.x - n.y * n.y), 0.0);
}

// Irradiance with nothing in the way.
vec3 open(vec3 n) {
  vec3 e = sky(n);
  for (int j = 0; j < lights; j++) { take(j, vec2(0, 1)); e += strength[j] * openShare(j, n); }
  return e;
}

// The normal of the side of a thing that faces x.
vec3 facing(int thing, vec3 x) {
  if (thing == BALL) return normalize(x - ball.xyz);
  vec3 q = toBox(x - boxCentre), d = max(abs(q) - boxHalf, 0.0);
  return fromBox(normalize(sign(q) * d + 1e-6));
}

// Radiance that a highlight adds for a light of unit irradiance: a lobe around the reflected ray, whose angle is
// counted from the nearest point of the disc (the representative point), and at most the radiance of the disc.
float highlight(vec3 mirrored) {
  float angle = max(acos(clamp(dot(mirrored, light.axis), -1.0, 1.0)) - asin(light.sine), 0.0);
  return pow(max(cos(min(angle, 1.57)), 0.0), exponent) / (PI * (light.sine * light.sine + 2.0 / (exponent + 2.0)));
}

#if MODELS == 2
//PATHS
#endif

// Irradiance of a point of the floor or of a thing with shadows and reflected light, and the highlight towards the eye.
// A thing sees the floor at one point: the second stage.
vec3 received(vec3 x, vec3 n, int id, vec3 mirrored, out vec3 gloss) {
  bool exact = shadows == 2;
  float below = overFloor ? 0.5 - 0.5 * n.y : 0.0, taken = 0.0;
  vec3 total = vec3(0);
  gloss = vec3(0);
  for (int stage = 0; stage < 2; stage++) {
    bool gathers = stage == 1;
    if (gathers && (id == FLOOR || below <= 0.0 || !exact || MODELS == 2)) break;
    int self = gathers ? FLOOR : id;
    vec3 p = x, m = n, e = vec3(0), product = vec3(1), all = vec3(1);
    if (gathers) {
      vec3 d = n - (max(n.y, 0.0) + TILT) * UP;
      p = x - d * (x.y / d.y); p.y = 0.0; m = UP;
    }
    if (exact) look(p, self);
    if (!exact && self == FLOOR) all = open(m);
#if MODELS == 2
    Gather gather = gatherOf(p, m, self);
    e += gather.irradiance;
#endif
    float ball_ = 0.0, box_ = 0.0;
    for (int j = exact ? FACTORS : AMBIENT; j < lights; j++) {
      if (j == FACTORS && self == FLOOR) continue;
      if (j >= 0) take(j, gathers ? BLUR : vec2(0, 1));
      float all_ = j == FACTORS ? 0.0 : openShare(j, m), off = 0.0;
      if (j >= 0 && all_ <= 0.0) continue;
      bool ray = !soft || light.sine < 3e-4;
      if (exact && j >= 0 && !gathers && ray) off = blocked(p, direction[j], self) ? all_ : 0.0;
      WHEN(exact && (j < 0 || gathers || !ray)) off = hidden(j, m, self);
      if (!exact && self == FLOOR && j >= 0 && shadows == 1 && (blocked(p, direction[j], self) || modelBlocks(p, direction[j]))) product *= 1.0 - strength[j] * all_ / all;
      if (j == FACTORS || (j == AMBIENT && self == FLOOR)) { ball_ = factorBall; box_ = factorBox; }
      off = min(off, all_);
#if MODELS == 2
      if (j == AMBIENT) off += gather.hidden;
      if (j >= 0) off += modelHides(j, p, m, self);
#else
      if (exact && j >= 0 && !gathers && modelBlocks(p, direction[j])) off = all_;
#endif
      if (j == AMBIENT) e += sky(m) * (1.0 - off / max(all_, 1e-9));
      if (j >= 0) e += strength[j] * (all_ - off);
      if (glossy && j >= 0 && !gathers && id != FLOOR) gloss += strength[j] * (1.0 - off / all_) * highlight(mirrored);
    }
    e *= product;
    if (exact && MODELS != 2) {
      // The side of a thing that faces p sees sky, lights and, for the share `back`, the floor at p or lit fully.
      vec3 back = vec3(0);
      for (int k = BALL; k <= BOX; k++) {
        if (k == self || !has(k)) continue;
        vec3 r = (k == BALL ? ball_ : box_) * albedo[k - 1];
        WHEN(r.x + r.y + r.z > 1e-4) {
          vec3 f = facing(k, p);
          float low = overFloor ? 0.5 - 0.5 * f.y : 0.0;
          e += r * open(f);
          if (self == FLOOR) back += r * low * floorAlbedo;
          WHEN(self != FLOOR) e += r * low * floorAlbedo * open(UP);
        }
      }
      e /= 1.0 - back;
    }
    if (!gathers) { total = e; taken = ball_ + box_; }
    else total += below * (1.0 - min(taken, 1.0)) * floorAlbedo * e;
  }
  if (!exact && id != FLOOR && overFloor) total += below * floorAlbedo * open(UP);
  return total;
}

// The map around the origin, as the eye sees it: projected on the ground, and beyond the dome on the dome.
vec3 background(vec3 d) {
  float t = d.y < 0.0 ? -eye.y / d.y : 1e30;
  vec3 x = eye + t * d;
  if (t > 1e29 || dot(x.xz, x.xz) > dome * dome) {
    float b = dot(eye, d), c = dot(eye, eye) - dome * dome;
    x = eye + (sqrt(max(b * b - c, 0.0)) - b) * d;
  }
  x = normalize(x - vec3(0, cameraHeight, 0));
  vec2 at = vec2(0.5 - atan(x.x, x.z) / (2.0 * PI), acos(clamp(x.y, -1.0, 1.0)) / PI);
  return white * textureLod(map, at, 0.0).rgb;
}

vec3 encode(vec3 x) {
  x = clamp(x, 0.0, 1.0);
  return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}

void table() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(points, at, 0);
  int self = int(p.w);
  vec3 n = texelFetch(normals, at, 0).xyz;
  look(p.xyz, self);
  if (column >= 0) take(column, vec2(0, 1));
  float h = hidden(column, n, self);
  colour = vec4(min(h, column == FACTORS ? 1.0 : openShare(column, n)), factorBall, factorBox, 1);
}

void picture() {
  vec2 s = 2.0 * (gl_FragCoord.xy + jitter) / size - 1.0;
  vec3 d = normalize(camera * vec3(s.x * tanX, s.y * tanX * size.y / size.x, 1.0));
  float t = d.y < 0.0 ? -eye.y / d.y : 1e30;
  int id = t < 1e29 ? FLOOR : SKY;
  vec3 n = UP, m, gloss, c, own = albedo[0];
  float b = hitBall(eye, d), k = hitBox(eye, d, m);
  if (b > 0.0 && b < t) { t = b; id = BALL; n = (eye + t * d - ball.xyz) / ball.w; }
  if (k > 0.0 && k < t) { t = k; id = BOX; n = m; own = albedo[1]; }
  vec3 x = eye + t * d;
#if MODELS > 0
  Hit hit = trace(eye, d, false);
  if (hit.triangle >= 0 && hit.t < t) { Surface found = surfaceOf(hit, d); id = MODEL; x = found.x; n = found.n; own = found.albedo; }
#endif
  if (id == FLOOR) x.y = 0.0;
  bool thing = id == BALL || id == BOX || id == MODEL, lit = thing || (id == FLOOR && (flatFloor || length(x.xz) < dome));
  c = thing || (flatFloor && lit) ? vec3(1) : background(d);
  WHEN(lit && !(bare && thing)) {
    vec3 e = received(x, n, id, reflect(d, n), gloss);
    c *= thing ? own / PI * e + shine * gloss : flatFloor ? floorAlbedo / PI * e : e / open(n);
  }
  if (bare && thing) c = own / PI * open(n);
  // A pixel of the mean over rays may be brighter than white; an edge of the background may not.
  colour = vec4(floats ? c : min(exposure * c, MODELS == 2 && lit ? 8.0 : 1.0), 1);
}

// Three balls: under the map, under the rig, and the difference around grey.
void probes() {
  vec2 p = vec2(3, 1) * (gl_FragCoord.xy - origin) / size, q = 2.2 * fract(p) - 1.1;
  float r = dot(q, q), depth = sqrt(max(1.0 - r, 0.0));
  vec3 n = camera * vec3(q, -depth), scale = 0.7 * exposure / vec3(PI), rig = open(n);
  vec3 map_ = white * texture(normals, vec2(0.5 - atan(n.x, n.z) / (2.0 * PI), acos(clamp(n.y, -1.0, 1.0)) / PI)).rgb;
  vec3 c = p.x < 1.0 ? scale * map_ : p.x < 2.0 ? scale * rig : 0.5 + 4.0 * scale * (rig - map_);
  float soft_ = clamp((1.0 - sqrt(r)) * size.y / 2.2 + 0.5, 0.0, 1.0);
  colour = vec4(p.x < 2.0 ? encode(c) : clamp(c, 0.0, 1.0), soft_);
}

void main() {
  if (task == 0) picture();
  else if (task == 1) table();
  else probes();
}
