// SPDX-License-Identifier: Apache-2.0
// Each shape is healthy first; then one or two things are done to it.
#include "tests/stress/random_shapes.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace patina::stress {
namespace {

using Floats = std::vector<double>;
using Ints = std::vector<int>;
using std::numbers::pi;

std::string ints(const Ints& values) {
  std::string text = "[";
  for (const int v : values) text += fmt::format("{}{}", text.size() > 1 ? " " : "", v);
  return text + "]";
}

/// A shape whose points may be moved for another pose.
struct Shape {
  std::string head;  ///< the request up to its points
  std::string pointName = "P";
  int pointSize = 3;
  Floats points;
  std::string tail;  ///< what follows the points
};

std::string write(const Shape& shape, const Floats& points) {
  return fmt::format("{} \"{}\" {} {}\n", shape.head, shape.pointName, numbers(points), shape.tail);
}

// ---- Harm

/// Does one thing to the points of a shape.
void harmPoints(Dice& dice, ShapeNotes& notes, Shape& shape) {
  Floats& p = shape.points;
  const auto size = static_cast<size_t>(shape.pointSize);
  const auto count = static_cast<int>(p.size() / size);
  if (count < 2) return;
  const auto at = [&](int k) { return p.begin() + static_cast<ptrdiff_t>(size) * k; };
  const int a = dice.below(count), b = dice.below(count);
  switch (dice.below(7)) {
    case 0:
      notes.ingredients.insert("duplicate points");
      std::copy_n(at(a), size, at(b));
      break;
    case 1:
      notes.ingredients.insert("crossing edges");
      std::swap_ranges(at(a), at(a) + shape.pointSize, at(b));
      break;
    case 2:
      notes.ingredients.insert("points out of place");
      for (size_t c = 0; c < 3; ++c) at(a)[static_cast<ptrdiff_t>(c)] += dice.range(-1, 1);
      break;
    case 3:
      notes.ingredients.insert("all points on a line");
      for (int k = 0; k < count; ++k) at(k)[1] = at(k)[2] = 0;
      break;
    case 4:
      notes.ingredients.insert("all points in one place");
      for (int k = 1; k < count; ++k) std::copy_n(at(0), size, at(k));
      break;
    case 5:
      notes.ingredients.insert("odd coordinates");
      at(a)[dice.below(3)] = oddNumber(dice);
      break;
    default:
      notes.ingredients.insert("a row of points that coincide");
      for (int k = 1; k < std::min(count, 4); ++k) std::copy_n(at(0), size, at(k));
      break;
  }
}

/// Primitive variables that are strange, of a class with `count` values.
std::string oddVariables(Dice& dice, ShapeNotes& notes, const char* storage, int count) {
  std::string text;
  if (dice.chance(0.2)) {
    notes.ingredients.insert("odd normals");
    Floats n;
    for (int k = 0; k < 3 * count; ++k) n.push_back(dice.chance(0.3) ? oddNumber(dice) : dice.range(-1, 1));
    text += fmt::format("\"{} normal N\" {} ", storage, numbers(n));
  }
  if (dice.chance(0.2)) {
    const bool odd = dice.chance(0.4) && notes.allowStrangeColors;
    if (odd) notes.ingredients.insert("odd colours"), notes.strangeColors = true;
    Floats c;
    for (int k = 0; k < 3 * count; ++k)
      c.push_back(odd && dice.chance(0.3) ? oddNumber(dice) : dice.range(0, 0.9));
    text += fmt::format("\"{} color Cs\" {} ", storage, numbers(c));
  }
  if (dice.chance(0.2)) {
    notes.ingredients.insert("odd texture coordinates");
    Floats s;
    for (int k = 0; k < 2 * count; ++k) s.push_back(dice.chance(0.3) ? oddNumber(dice) : dice.unit());
    text += fmt::format("\"{} float[2] st\" {} ", storage, numbers(s));
  }
  if (dice.chance(0.05)) {
    notes.ingredients.insert("a variable of too few values");
    text += fmt::format("\"{} float heat\" [1] ", storage);
  }
  return text;
}

// ---- Shapes

std::string quadric(Dice& dice, ShapeNotes& notes) {
  double r = dice.range(0.3, 1), low = -r, high = r, sweep = 360, minor = 0.3 * r;
  Floats a = {r, 0, -0.5}, b = {0.4, 0.3, 0.6};
  switch (dice.below(12)) {
    case 0:
      r = 0, notes.ingredients.insert("quadric of radius 0");
      break;
    case 1:
      sweep = 0, notes.ingredients.insert("quadric of sweep 0");
      break;
    case 2:
      sweep = -dice.range(1, 720), notes.ingredients.insert("quadric of a sweep outside of 0 to 360");
      break;
    case 3:
      sweep = dice.pick({1e-30, 1e-4, 359.99999}), notes.ingredients.insert("quadric of a tiny sweep");
      break;
    case 4:
      high = low, minor = 0, notes.ingredients.insert("quadric of height 0");
      break;
    case 5:
      std::swap(low, high), notes.ingredients.insert("quadric upside down");
      break;
    case 6:
      r = oddNumber(dice), notes.ingredients.insert("quadric of an odd radius");
      break;
    case 7:
      b = a, minor = 2 * r, notes.ingredients.insert("hyperboloid through one point, spindle torus");
      break;
    case 8:
      a[2] = b[2], a[0] = oddNumber(dice), notes.ingredients.insert("odd hyperboloid");
      break;
    case 9:
      high = low + 1e-7, notes.ingredients.insert("quadric of a tiny height");
      break;
    default:
      sweep = dice.range(90, 360);
      break;
  }
  const auto f = [](double v) { return number(v); };
  std::string text;
  switch (dice.below(7)) {
    case 0:
      text = fmt::format("Sphere {} {} {} {}", f(r), f(low), f(high), f(sweep));
      break;
    case 1:
      text = fmt::format("Cylinder {} {} {} {}", f(r), f(low), f(high), f(sweep));
      break;
    case 2:
      text = fmt::format("Cone {} {} {}", f(high), f(r), f(sweep));
      break;
    case 3:
      text = fmt::format("Disk {} {} {}", f(low), f(r), f(sweep));
      break;
    case 4:
      text = fmt::format("Paraboloid {} {} {} {}", f(r), f(low), f(high), f(sweep));
      break;
    case 5:
      text = fmt::format("Torus {} {} 0 360 {}", f(r), f(minor), f(sweep));
      break;
    default:
      text = fmt::format("Hyperboloid {} {} {} {} {} {} {}", f(a[0]), f(a[1]), f(a[2]), f(b[0]), f(b[1]),
                         f(b[2]), f(sweep));
      break;
  }
  return text + " " + oddVariables(dice, notes, "varying", 4) + "\n";
}

void addRing(Floats& points, int corners, double radius, double z) {
  for (int k = 0; k < corners; ++k)
    points.insert(points.end(),
                  {radius * std::cos(2 * pi * k / corners), radius * std::sin(2 * pi * k / corners), z});
}

Shape polygon(Dice& dice, ShapeNotes& notes) {
  const int corners = dice.chance(0.2) ? dice.below(3) + 1 : dice.pick({3, 4, 4, 5, 8, 100});
  if (corners < 3) notes.ingredients.insert("polygon of fewer than three corners");
  Shape shape{"Polygon", "P", 3, {}, oddVariables(dice, notes, "varying", corners)};
  addRing(shape.points, corners, 1, 0);
  return shape;
}

Shape generalPolygon(Dice& dice, ShapeNotes& notes) {
  const int outside = dice.pick({3, 4, 7}), inside = dice.pick({3, 4, 5});
  const double hole = dice.pick({0.5, 0.5, 1.0, 1.5, 0.0});
  if (hole >= 1) notes.ingredients.insert("hole larger than its polygon");
  if (hole == 0) notes.ingredients.insert("hole without area");
  Shape shape{fmt::format("GeneralPolygon [{} {}]", outside, inside), "P", 3, {}, ""};
  addRing(shape.points, outside, 1, 0), addRing(shape.points, inside, hole, 0);
  return shape;
}

const Floats kCube = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1};
const Ints kCubeFaces = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};

/// Adds faces to a cube that a mesh should not have.
void harmMesh(Dice& dice, ShapeNotes& notes, Ints& sizes, Ints& corners, Floats& points) {
  const auto add = [&](const char* what, const Ints& face) {
    notes.ingredients.insert(what);
    sizes.push_back(static_cast<int>(face.size()));
    corners.insert(corners.end(), face.begin(), face.end());
  };
  const auto fresh = static_cast<int>(points.size() / 3);
  switch (dice.below(8)) {
    case 0:
      points.insert(points.end(), {0, 0, 1.8});
      add("three faces at an edge", {4, 5, fresh});
      break;
    case 1:
      notes.ingredients.insert("isolated vertices");
      points.insert(points.end(), {5, 5, 5, oddNumber(dice), 0, 0});
      break;
    case 2: {
      addRing(points, 100, 0.8, 1.2);
      Ints face;
      for (int k = 0; k < 100; ++k) face.push_back(fresh + k);
      add("face of a hundred corners", face);
      break;
    }
    case 3:
      add("face that has a vertex twice", {0, 1, 1, 3});
      break;
    case 4:
      add("face that is there twice", {0, 2, 3, 1});
      break;
    case 5:
      add("face of two corners", {0, 7});
      break;
    case 6:
      add("vertex that is not there", {0, 1, 4711});
      break;
    default:
      points.insert(points.end(), {2, 2, 1, 1.5, 2, 1.5});
      add("two parts that share a vertex", {7, fresh, fresh + 1});
      break;
  }
}

Shape mesh(Dice& dice, ShapeNotes& notes) {
  Ints sizes(6, 4), corners = kCubeFaces;
  Shape shape{"", "P", 3, kCube, ""};
  for (double& v : shape.points) v *= 0.6;
  for (int k = dice.below(3); k > 0; --k) harmMesh(dice, notes, sizes, corners, shape.points);
  const auto count = static_cast<int>(shape.points.size() / 3);
  if (dice.chance(0.4)) {
    shape.head = fmt::format("PointsPolygons {} {}", ints(sizes), ints(corners));
  } else {
    std::string tags = "[\"interpolateboundary\"] [0 0] [] []";
    if (dice.chance(0.5))
      tags = fmt::format(
          "[\"crease\" \"corner\" \"interpolateboundary\"] [5 1 1 1 0 0] [0 1 5 4 0 3] [{} {}] []",
          dice.pick({"0", "2.5", "1e30"}), dice.pick({"3", "-1", "10"}));
    if (dice.chance(0.1)) tags = "[\"hole\" \"interpolateboundary\"] [2 0 0 0] [0 1] [] []";
    // Tags of old files have no strings: two counts each.
    tags = tags.substr(0, tags.rfind(" []"));
    shape.head = fmt::format("SubdivisionMesh \"{}\" {} {} {}",
                             dice.chance(0.85) ? "catmull-clark" : dice.pick({"loop", "bilinear"}),
                             ints(sizes), ints(corners), tags);
  }
  shape.tail = oddVariables(dice, notes, "vertex", count);
  return shape;
}

Shape patchMesh(Dice& dice, ShapeNotes& notes) {
  const bool cubic = dice.chance(0.5);
  const int n = 4;
  Shape shape{"", "P", 3, {}, ""};
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < n; ++k)
      shape.points.insert(shape.points.end(), {k * 2.0 / 3 - 1, j * 2.0 / 3 - 1, dice.range(-0.3, 0.3)});
  if (dice.chance(0.3)) {
    notes.ingredients.insert("patch with a collapsed edge");
    for (int k = 1; k < n; ++k) std::copy_n(shape.points.begin(), 3, shape.points.begin() + 3 * k);
  }
  shape.head = cubic ? "Patch \"bicubic\""
                     : fmt::format("PatchMesh \"bilinear\" {} \"{}\" {} \"nonperiodic\"", n,
                                   dice.pick({"nonperiodic", "periodic"}), n);
  shape.tail = oddVariables(dice, notes, "varying", 4);
  return shape;
}

Shape nuPatch(Dice& dice, ShapeNotes& notes) {
  Floats uknot = {0, 0, 0, 0.5, 1, 1, 1}, vknot = {0, 0, 0, 1, 1, 1};
  std::string least = "0";
  Shape shape{"", "Pw", 4, {}, ""};
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < 4; ++k) {
      const double w = dice.range(0.5, 2);
      shape.points.insert(shape.points.end(),
                          {(k * 2.0 / 3 - 1) * w, (j - 1.0) * w, dice.range(-0.4, 0.4) * w, w});
    }
  switch (dice.below(7)) {
    case 0:
      uknot = {0, 0, 0, 0, 1, 1, 1}, notes.ingredients.insert("knots repeated too often");
      break;
    case 1:
      uknot.assign(7, 0.5), notes.ingredients.insert("knots that are all the same");
      break;
    case 2:
      uknot = {0, 0, 0, 0.9, 0.5, 1, 1}, notes.ingredients.insert("knots that descend");
      break;
    case 3:
      shape.points[4 * static_cast<size_t>(dice.below(12)) + 3] = 0, notes.ingredients.insert("weight 0");
      break;
    case 4:
      for (size_t k = 3; k < shape.points.size(); k += 4) shape.points[k] = 0;
      notes.ingredients.insert("all weights 0");
      break;
    case 5:
      shape.points[3] = -1, notes.ingredients.insert("negative weight");
      break;
    default:
      break;
  }
  if (dice.chance(0.15)) least = "2", notes.ingredients.insert("NURBS without an interval");
  shape.head = fmt::format("NuPatch 4 3 {} {} 1 3 3 {} 0 1", numbers(uknot), least, numbers(vknot));
  return shape;
}

Shape curves(Dice& dice, ShapeNotes& notes) {
  const bool cubic = dice.chance(0.6);
  const int count = 4, many = dice.below(3) + 1;
  Shape shape{fmt::format("Curves \"{}\" [", cubic ? "cubic" : "linear"), "P", 3, {}, ""};
  for (int c = 0; c < many; ++c) {
    shape.head += fmt::format(" {}", count);
    for (int k = 0; k < count; ++k)
      shape.points.insert(shape.points.end(), {dice.range(-1, 1), dice.range(-1, 1), dice.range(-1, 1)});
  }
  shape.head += " ] \"nonperiodic\"";
  double width = dice.range(0.01, 0.2);
  switch (dice.below(5)) {
    case 0:
      width = 0, notes.ingredients.insert("curves of width 0");
      break;
    case 1:
      width = dice.pick({1e-40, 1e-10, -0.1}), notes.ingredients.insert("curves of an odd width");
      break;
    case 2:
      width = dice.pick({10.0, 1e10}), notes.ingredients.insert("curves wider than long");
      break;
    default:
      break;
  }
  shape.tail = fmt::format("\"constantwidth\" [{}]", number(width));
  return shape;
}

Shape points(Dice& dice, ShapeNotes& notes) {
  Shape shape{"Points", "P", 3, {}, ""};
  Floats widths;
  for (int k = 0; k < 12; ++k) {
    for (int c = 0; c < 3; ++c) shape.points.push_back(dice.range(-1, 1));
    widths.push_back(dice.chance(0.2) ? oddNumber(dice) : dice.range(0.02, 0.4));
  }
  notes.ingredients.insert("points of odd widths");
  shape.tail = fmt::format("\"varying float width\" {}", numbers(widths));
  return shape;
}

std::string blobby(Dice& dice, ShapeNotes& notes) {
  Floats m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, n = m;
  n[12] = 0.7;
  switch (dice.below(4)) {
    case 0:
      m[0] = 0, notes.ingredients.insert("blobby of a singular matrix");
      break;
    case 1:
      m[5] = oddNumber(dice), notes.ingredients.insert("blobby of an odd matrix");
      break;
    case 2:
      n = m, notes.ingredients.insert("blobs that coincide");
      break;
    default:
      break;
  }
  m.insert(m.end(), n.begin(), n.end());
  return fmt::format("Blobby 2 [1001 0 1001 16 {} 2 0 1] {} [\"\"]\n", dice.pick({0, 0, 5}), numbers(m));
}

std::string solid(Dice& dice, ShapeNotes& notes) {
  const char* operation = dice.pick({"difference", "intersection", "union"});
  const double shift = dice.pick({0.0, 0.4, 5.0}), r = dice.pick({0.8, 0.5});
  if (shift == 0) notes.ingredients.insert("set operation of solids that coincide");
  return fmt::format(
      "SolidBegin \"{}\" SolidBegin \"primitive\" Sphere .8 -.8 .8 360 SolidEnd\n"
      "SolidBegin \"primitive\" Translate {} 0 0 Sphere {} {} {} 360 SolidEnd SolidEnd\n",
      operation, number(shift), number(r), number(-r), number(r));
}

}  // namespace

std::string randomShape(Dice& dice, ShapeNotes& notes, int times) {
  Shape shape;
  const int kind = dice.below(13);
  if (kind < 3 || (kind < 5 && times > 1)) {  // the same each time: what holds it moves
    const std::string once = quadric(dice, notes);
    std::string text;
    for (; times > 0; --times) text += once;
    return text;
  }
  switch (kind) {
    case 3:
      return blobby(dice, notes);
    case 4:
      return solid(dice, notes);
    case 5:
      shape = polygon(dice, notes);
      break;
    case 6:
      shape = generalPolygon(dice, notes);
      break;
    case 7:
      shape = patchMesh(dice, notes);
      break;
    case 8:
      shape = nuPatch(dice, notes);
      break;
    case 9:
      shape = curves(dice, notes);
      break;
    case 10:
      shape = points(dice, notes);
      break;
    default:
      shape = mesh(dice, notes);
      break;
  }
  for (int k = dice.below(3); k > 0; --k) harmPoints(dice, notes, shape);
  std::string text = write(shape, shape.points);
  for (int k = 1; k < times; ++k) {
    Floats moved = shape.points;
    const auto size = static_cast<size_t>(shape.pointSize);
    for (size_t i = 0; i < moved.size(); i += size) moved[i] += 0.3;
    text += write(shape, moved);
  }
  return text;
}

}  // namespace patina::stress
