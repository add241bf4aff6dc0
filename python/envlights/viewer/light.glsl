// Irradiance that a ball and a box hide from a point, in closed form.
//
// The cosine-weighted solid angle of a region of the sphere is half the integral of n . (w x dw) along its border,
// counterclockwise. Every region here is a convex polygon of great circles, cut by one cap: the part of a light behind
// the box is one, and that behind ball and box is two of them, because the great circle through the crossings of two
// circles divides a lens into a piece of each cap. Seen from the axis of the cap, an edge within it adds a triangle,
// and an edge outside of it adds a sector of the cap. All terms are written in offsets from that axis and in sines, so
// that the rounding of 32-bit floats is divided by the radius of a light once, and not twice.
// A branch that software renderers skip as well: they compute both sides of an `if`.
#define WHEN(x) for (bool go = (x); go; go = false)
const float PI = 3.14159265358979;
const vec3 UP = vec3(0, 1, 0);

// Directions around an axis: sine and cosine of the angle, which is below 90 degrees.
struct Cap { vec3 axis; float sine, cosine; };

Cap light;         // the light that is hidden
Cap sphere;        // the ball as seen from the point
vec3 above;        // the point as seen from the centre of the box
int sides;         // corners of the silhouette of the box, counterclockwise; three bits of `silhouette` for each
int silhouette;
bool apart;        // true if a side of the silhouette has the ball beyond it

vec3 corner(int k);

// Irradiance of a disc at a normal over that at normal incidence; see src/kernels/disc.rs.
float discShare(float c, Cap disc) {
  float s = disc.sine, k = disc.cosine, share = max(c, 0.0);
  WHEN(abs(c) < s) {
    float q = c / s, h = sqrt((1.0 - q) * (1.0 + q)), u = h * s / k, v = u * u, rest;
    if (s < 0.1) rest = u - u * h * h / (k * k) * (1.0 / 3.0 - v * (0.2 - v * (1.0 / 7.0 - v / 9.0)));
    else rest = atan(h * s, k) / (s * s) - h * k / s;
    share = (c * atan(h, -q * k) + rest) / PI;
  }
  return share;
}

// False if no direction is in both caps.
bool meet(Cap a, Cap b) {
  bool wide = a.cosine * b.sine + a.sine * b.cosine < 0.0;
  return wide || dot(a.axis, b.axis) > a.cosine * b.cosine - a.sine * b.sine;
}

// Part of cap a on the inner side of a great circle: `offset` is the cosine between its normal and the axis, `across`
// the component of the normal perpendicular to the axis.
float segment(vec3 n, Cap a, float offset, vec3 across) {
  float s2 = a.sine * a.sine, root = s2 - offset * offset, c = dot(n, a.axis);
  if (root <= 0.0) return offset > 0.0 ? PI * s2 * c : 0.0;
  float rest = atan(sqrt(root), -offset * a.cosine), d = atan(sqrt(root), a.cosine);
  return c * (offset * d + s2 * rest) + dot(n, across) * (d - a.cosine * sqrt(root) / (1.0 - offset * offset));
}

// Cosine between the axis of a and the great circle through the crossings of both, times its length.
float offsetOf(Cap a, Cap b, float c, float xx) {
  if (c + b.cosine < 0.2) return c * a.cosine - b.cosine;
  return (b.sine * b.sine - xx) / (c + b.cosine) - c * a.sine * a.sine / (1.0 + a.cosine);
}

// Great circle through the crossings of two caps, towards the axis of b: a bounds their lens on its inner side.
vec3 divide(Cap a, Cap b) { return b.axis * a.cosine - a.axis * b.cosine; }

// Intersection of two caps above the horizon.
float lens(vec3 n, Cap a, Cap b) {
  vec3 x = cross(a.axis, b.axis);
  float c = dot(a.axis, b.axis), xx = dot(x, x), size = length(divide(a, b));
  if (size < 1e-6) return PI * min(a.sine * a.sine, b.sine * b.sine) * dot(n, a.axis);
  return segment(n, a, offsetOf(a, b, c, xx) / size, (b.axis - c * a.axis) * a.cosine / size)
       + segment(n, b, offsetOf(b, a, c, xx) / size, (a.axis - c * b.axis) * b.cosine / size);
}

// Angle over its sine.
float overSine(float s, float c) { return s < 1e-3 && c > 0.0 ? 1.0 + s * s / 6.0 : atan(s, c) / s; }

// Angle around the axis between two offsets from it, in the sense of a great circle with this offset.
float turn(vec3 axis, float offset, vec3 from, vec3 to) {
  float angle = atan(abs(dot(axis, cross(from, to))), dot(from, to) + 1e-30);
  return offset < 0.0 ? -angle : angle;
}

// Twice the part of a cap that an edge a -> b of a polygon bounds, with the normal m; `behind` stays true while the
// polygon may contain the direction opposite to the axis.
float edge(vec3 n, Cap k, vec3 a, vec3 b, vec3 m, inout bool behind) {
  float offset = dot(k.axis, m), s2 = k.sine * k.sine, root = s2 - offset * offset, r2 = 1.0 - offset * offset;
  float ha = dot(a, k.axis), hb = dot(b, k.axis), c = dot(n, k.axis);
  vec3 p = a - ha * k.axis, q = b - hb * k.axis, along = cross(m, k.axis);
  bool inA = ha > 0.0 && dot(p, p) <= s2, inB = hb > 0.0 && dot(q, q) <= s2;
  behind = behind && offset < 0.0;
  bool hits = root > 0.0 && (inA || inB || (dot(p, along) < 0.0 && dot(q, along) > 0.0));
  float sum = 0.0, rim = s2 / (1.0 + k.cosine);
  WHEN(!hits) sum = s2 * c * turn(k.axis, offset, p, q);
  WHEN(hits) {
    vec3 middle = -offset * k.cosine / r2 * (m - offset * k.axis), half_ = sqrt(root) / r2 * along;
    WHEN(!inA) {
      vec3 enter = middle - half_;
      sum += s2 * c * turn(k.axis, offset, p, enter) - rim * dot(n, cross(k.axis, enter));
      p = enter; ha = k.cosine;
    }
    WHEN(!inB) {
      vec3 leave = middle + half_;
      sum += s2 * c * turn(k.axis, offset, leave, q) + rim * dot(n, cross(k.axis, leave));
      q = leave; hb = k.cosine;
    }
    vec3 pq = cross(p, q);
    float g = overSine(length(cross(k.axis, ha * q - hb * p) + pq), ha * hb + dot(p, q));
    sum += c * dot(k.axis, pq) * g + dot(n, cross(k.axis, q * (ha * g - 1.0) - p * (hb * g - 1.0)));
  }
  return sum;
}

// Keep the part of an edge on the inner side of the great circle h; where the border leaves and enters that side.
bool keep(vec3 h, inout vec3 a, inout vec3 b, inout vec3 leave, inout vec3 enter, inout bool cuts) {
  float da = dot(a, h), db = dot(b, h);
  WHEN(da < 0.0 && db >= 0.0) { a = normalize(a * db - b * da); enter = a; cuts = true; }
  WHEN(da >= 0.0 && db < 0.0) { b = normalize(b * da - a * db); leave = b; cuts = true; }
  return da >= 0.0 || db >= 0.0;
}

// Cosine-weighted solid angle of the box above the horizon of n, within a cap if `capped`.
float outline(vec3 n, Cap k, bool capped) {
  vec3 first = corner(0), last = first, a = normalize(last);
  bool behind = true;
  float sum = 0.0;
  for (int i = 1; i <= sides; i++) {
    vec3 next = first;
    WHEN(i < sides) next = corner(i);
    vec3 b = normalize(next), m = normalize(cross(last, next - last));
    apart = apart || dot(sphere.axis, m) < -sphere.sine;
    WHEN(capped) sum += edge(n, k, a, b, m, behind);
    WHEN(!capped) sum += dot(n, m) * atan(length(cross(a, b)), dot(a, b) + 1e-30);
    last = next; a = b;
  }
  if (capped && behind) sum += 2.0 * PI * k.sine * k.sine * dot(n, k.axis);
  return 0.5 * sum;
}

// Cosine-weighted solid angle of the box, or of the hemisphere of n if `dome`, on the inner side of two great circles
// (zero cuts nothing), within a cap if `capped`.
float region(vec3 n, Cap k, bool capped, bool dome, vec3 cut1, vec3 cut2) {
  vec3 u = normalize(abs(n.x) < 0.7 ? vec3(0, -n.z, n.y) : vec3(n.z, 0, -n.x)), v = cross(n, u);
  vec3 leave1, enter1, leave2, enter2;
  bool cuts1 = false, cuts2 = false, behind = true, any = false;
  float sum = 0.0;
  int count = dome ? 4 : sides;
  vec3 last = dome ? u : corner(0), at = last, unit = normalize(last);
  // The edges, and then the arcs of both great circles between the crossings with the edges.
  for (int i = 0; i < count + (cuts1 || cuts2 ? 2 : 0); i++) {
    vec3 a, b, m;
    bool stays = true;
    WHEN(i < count) {
      vec3 next = dome ? ((i & 1) == 0 ? v : -u) * (i < 2 ? 1.0 : -1.0) : i + 1 < count ? corner(i + 1) : at;
      a = unit; b = normalize(next);
      m = dome ? n : normalize(cross(last, next - last));
      last = next; unit = b;
      stays = keep(cut1, a, b, leave1, enter1, cuts1);
    }
    if (i == count) { a = leave1; b = enter1; m = cut1; stays = cuts1; }
    WHEN(stays && i <= count) stays = keep(cut2, a, b, leave2, enter2, cuts2);
    if (i == count + 1) { a = leave2; b = enter2; m = cut2; stays = cuts2; }
    any = any || stays;
    WHEN(stays && capped) sum += edge(n, k, a, b, m, behind);
    WHEN(stays && !capped) sum += dot(n, m) * atan(length(cross(a, b)), dot(a, b) + 1e-30);
  }
  if (capped && any && behind) sum += 2.0 * PI * k.sine * k.sine * dot(n, k.axis);
  return 0.5 * sum;
}
