// What the rays of a refined picture find: the closed forms stay, and the model is what one ray a light and one ray
// around the normal meet, in the mean over the frames.

// Axes across a direction (Duff et al. 2017).
mat3 axesOf(vec3 n) {
  float s = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (s + n.z), b = n.x * n.y * a;
  return mat3(1.0 + s * n.x * n.x * a, s * b, -s * n.x, b, s + n.y * n.y * a, -n.y, n);
}

// A point of the disc of the light that was taken, evenly over its solid angle.
vec3 pointOfDisc(uint dimension) {
  vec2 r = random(dimension);
  float depth = r.x * light.sine * light.sine / (1.0 + light.cosine), s = sqrt(depth * (2.0 - depth)), phi = 2.0 * PI * r.y;
  return axesOf(light.axis) * vec3(s * cos(phi), s * sin(phi), 1.0 - depth);
}

// Share of the light that was taken which the model alone hides: over that at normal incidence.
float modelHides(int j, vec3 x, vec3 n, int self) {
  vec3 w = pointOfDisc(uint(8 + j));
  float c = dot(w, n) * 2.0 / (1.0 + light.cosine);
  return c > 0.0 && !blocked(x, w, self) && modelBlocks(x, w) ? c : 0.0;
}

// Irradiance of a surface by the lights with their shadows: one light is tried, with a chance like its irradiance.
vec3 lightOn(vec3 x, vec3 n, int self, uint dimension) {
  float sum = 0.0, shares[8];
  for (int j = 0; j < lights; j++) { take(j, vec2(0, 1)); sum += shares[j] = openShare(j, n) * dot(strength[j], vec3(0.2126, 0.7152, 0.0722)); }
  if (sum <= 0.0) return vec3(0);
  float left = random(dimension).x * sum;
  int chosen = 0;
  for (int j = 0; j < lights; j++) { if (left >= 0.0 && shares[j] > 0.0) chosen = j; left -= shares[j]; }
  take(chosen, vec2(0, 1));
  vec3 w = pointOfDisc(dimension + 1u);
  if (dot(w, n) <= 0.0 || blocked(x, w, self) || modelBlocks(x, w)) return vec3(0);
  return strength[chosen] * openShare(chosen, n) * sum / shares[chosen];
}

// Surfaces on the path of the light to a point.
const int BOUNCES = 2;
struct Gather { float hidden; vec3 irradiance; };

// A path that leaves along a ray around the normal, with a density like its cosine: the share of the ambient term that
// the model alone hides, and the irradiance that other surfaces reflect. Where the path ends, the whole sky is taken to
// be in sight; this stands in for further surfaces.
Gather gatherOf(vec3 x, vec3 n, int self) {
  Gather g = Gather(0.0, vec3(0));
  vec3 through = vec3(1);
  for (int bounce = 0; bounce < BOUNCES; bounce++) {
    uint dimension = uint(16 + 4 * bounce);
    vec2 r = random(dimension);
    float s = sqrt(r.x), phi = 2.0 * PI * r.y;
    vec3 w = axesOf(n) * vec3(s * cos(phi), s * sin(phi), sqrt(1.0 - r.x)), m, up = UP, own = floorAlbedo;
    Hit hit = trace(x, w, false);
    bool met = hit.triangle >= 0, above = w.y > 0.0 || !overFloor;
    if (bounce == 0 && met && above && !blocked(x, w, self)) g.hidden = 1.0;
    float t = met ? hit.t : FAR, b = self == BALL ? -1.0 : hitBall(x, w), k = self == BOX ? -1.0 : hitBox(x, w, m);
    float f = overFloor && self != FLOOR && w.y < 0.0 ? -x.y / w.y : -1.0;
    int id = met ? MODEL : SKY;
    if (b > 0.0 && b < t) { t = b; id = BALL; }
    if (k > 0.0 && k < t) { t = k; id = BOX; }
    if (f > 0.0 && f < t) { t = f; id = FLOOR; }
    if (id == SKY) {
      if (bounce > 0 && above) g.irradiance += through * sky(n) / max(openShare(AMBIENT, n), 1e-3);
      break;
    }
    x += t * w;
    if (id == FLOOR) x.y = 0.0;
    if (id == BALL) { up = (x - ball.xyz) / ball.w; own = albedo[0]; }
    if (id == BOX) { up = m; own = albedo[1]; }
    if (id == MODEL) { Surface found = surfaceOf(hit, w); x = found.x; up = found.n; own = found.albedo; }
    n = up;
    self = id;
    through *= own;
    g.irradiance += through * lightOn(x, n, self, dimension + 1u);
    if (bounce == BOUNCES - 1) g.irradiance += through * sky(n);
  }
  return g;
}
