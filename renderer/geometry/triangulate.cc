// SPDX-License-Identifier: Apache-2.0
// Ear clipping: corners that are no ears sleep until the vertex in their way has gone.
#include "renderer/geometry/triangulate.h"

#include <algorithm>
#include <cmath>

namespace patina {
namespace {

using Point = Triangulator::Point;

/// Twice the signed area of a triangle. Exact for coordinates that began as floats of similar size.
double orient(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool inside(const std::array<Point, 3>& t, const Point& p) {
  return orient(t[0], t[1], p) >= 0 && orient(t[1], t[2], p) >= 0 && orient(t[2], t[0], p) >= 0;
}

/// Twice the signed area of a loop, by differences so that a polygon far from the origin keeps its digits.
double loopArea(std::span<const Point> loop) {
  double sum = 0;
  for (size_t i = 1; i + 1 < loop.size(); ++i) sum += orient(loop[0], loop[i], loop[i + 1]);
  return sum;
}

constexpr uint32_t kLeafSize = 8;
constexpr size_t kWorkPerVertex = 1000, kWorkBase = 1 << 20;

}  // namespace

bool Triangulator::run(std::span<const Point> points, std::span<const uint32_t> loopSizes,
                       std::vector<Triangle>& out) {
  nodes_.clear();
  work_ = 0;
  workLimit_ = kWorkBase + kWorkPerVertex * points.size();
  if (loopSizes.empty() || loopSizes[0] < 3) return false;

  // The outline is made to turn counter-clockwise by mirroring, the holes to turn clockwise by their
  // direction.
  double area = loopArea(points.first(loopSizes[0]));
  const bool mirror = area < 0;
  area = std::abs(area);
  const uint32_t start = addLoop(points, 0, loopSizes[0], mirror, true);
  const auto outlineEnd = static_cast<uint32_t>(nodes_.size());
  bool simple = true;
  std::vector<Hole> holes;
  uint32_t offset = loopSizes[0];
  for (size_t l = 1; l < loopSizes.size(); offset += loopSizes[l++]) {
    const double holeArea = loopSizes[l] < 3 ? 0 : loopArea(points.subspan(offset, loopSizes[l]));
    if (holeArea == 0) continue;
    const auto first = static_cast<uint32_t>(nodes_.size());
    uint32_t leftmost = addLoop(points, offset, loopSizes[l], mirror, (holeArea < 0) != mirror);
    const auto end = static_cast<uint32_t>(nodes_.size());
    for (uint32_t n = first; n < end; ++n)
      if (nodes_[n].at.x < nodes_[leftmost].at.x ||
          (nodes_[n].at.x == nodes_[leftmost].at.x && nodes_[n].at.y < nodes_[leftmost].at.y))
        leftmost = n;
    holes.push_back({leftmost, first, end});
    area -= std::abs(holeArea);
  }
  if (!holes.empty()) simple = bridgeHoles(holes, outlineEnd);

  const size_t firstTriangle = out.size();
  simple = clip(start, out) && simple;
  double covered = 0;
  for (size_t i = firstTriangle; i < out.size(); ++i)
    covered += std::abs(orient(points[out[i][0]], points[out[i][1]], points[out[i][2]]));
  return simple && std::abs(covered - area) <= 1e-6 * std::max(covered, area);
}

/// Links a loop without repeated points; returns its first node.
uint32_t Triangulator::addLoop(std::span<const Point> points, uint32_t first, uint32_t size, bool mirror,
                               bool forward) {
  const auto begin = static_cast<uint32_t>(nodes_.size());
  for (uint32_t i = 0; i < size; ++i) {
    const uint32_t point = first + (forward ? i : size - 1 - i);
    const Point at(mirror ? -points[point].x : points[point].x, points[point].y);
    if (nodes_.size() > begin && (nodes_.back().at == at || (i + 1 == size && nodes_[begin].at == at)))
      continue;
    const auto node = static_cast<uint32_t>(nodes_.size());
    nodes_.push_back({.at = at, .point = point, .previous = node - 1, .next = node + 1});
  }
  nodes_[begin].previous = static_cast<uint32_t>(nodes_.size() - 1);
  nodes_.back().next = begin;
  return begin;
}

// ---- The tree
// ----------------------------------------------------------------------------------------------------

void Triangulator::buildTree() {
  const auto count = static_cast<uint32_t>(nodes_.size());
  order_.resize(count);
  for (uint32_t i = 0; i < count; ++i) order_[i] = i;
  size_t leaves = 1;
  while (leaves * kLeafSize < count) leaves *= 2;
  tree_.resize(2 * leaves);
  buildTree(0, 0, count);
}

void Triangulator::buildTree(size_t index, uint32_t begin, uint32_t end) {
  TreeNode node{nodes_[order_[begin]].at, nodes_[order_[begin]].at, begin, end, 0};
  for (uint32_t i = begin; i < end; ++i) {
    const Node& n = nodes_[order_[i]];
    node.min = {std::min(node.min.x, n.at.x), std::min(node.min.y, n.at.y)};
    node.max = {std::max(node.max.x, n.at.x), std::max(node.max.y, n.at.y)};
    node.active += n.active;
  }
  tree_[index] = node;
  if (end - begin <= kLeafSize) {
    for (uint32_t i = begin; i < end; ++i) nodes_[order_[i]].leaf = static_cast<uint32_t>(index);
    return;
  }
  const uint32_t middle = begin + (end - begin) / 2;
  const bool alongX = node.max.x - node.min.x > node.max.y - node.min.y;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](uint32_t a, uint32_t b) {
                     return alongX ? nodes_[a].at.x < nodes_[b].at.x : nodes_[a].at.y < nodes_[b].at.y;
                   });
  buildTree(2 * index + 1, begin, middle);
  buildTree(2 * index + 2, middle, end);
}

void Triangulator::setActive(uint32_t node, bool active) {
  if (nodes_[node].active == active) return;
  nodes_[node].active = active;
  for (size_t index = nodes_[node].leaf;; index = (index - 1) / 2) {
    tree_[index].active += active ? 1u : ~0u;
    if (index == 0) return;
  }
}

/// Calls visitor(node) for the active nodes near a counter-clockwise triangle until one says true.
template <typename Visit>
bool Triangulator::visit(size_t index, const std::array<Point, 3>& triangle, const Visit& visitor) const {
  const TreeNode& node = tree_[index];
  ++work_;
  if (node.active == 0) return false;
  for (size_t e = 0; e < 3; ++e) {
    // The corner of the box farthest to the left of the edge decides whether the box is wholly to its right.
    const Point &a = triangle[e], &b = triangle[(e + 1) % 3];
    const Point far(b.y > a.y ? node.min.x : node.max.x, b.x > a.x ? node.max.y : node.min.y);
    if (orient(a, b, far) < 0) return false;
  }
  if (std::min({triangle[0].x, triangle[1].x, triangle[2].x}) > node.max.x ||
      std::max({triangle[0].x, triangle[1].x, triangle[2].x}) < node.min.x ||
      std::min({triangle[0].y, triangle[1].y, triangle[2].y}) > node.max.y ||
      std::max({triangle[0].y, triangle[1].y, triangle[2].y}) < node.min.y)
    return false;
  if (node.end - node.begin > kLeafSize)
    return visit(2 * index + 1, triangle, visitor) || visit(2 * index + 2, triangle, visitor);
  for (uint32_t i = node.begin; i < node.end; ++i) {
    ++work_;
    if (nodes_[order_[i]].active && visitor(order_[i])) return true;
  }
  return false;
}

// ---- Ears
// --------------------------------------------------------------------------------------------------------

double Triangulator::turn(uint32_t node) const {
  const Node& n = nodes_[node];
  return orient(nodes_[n.previous].at, n.at, nodes_[n.next].at);
}

/// A vertex in the closed triangle of a convex corner, kNil if there is none: then the corner is an ear.
uint32_t Triangulator::findBlocker(uint32_t ear) const {
  if (work_ > workLimit_) return kNil;
  const Node& node = nodes_[ear];
  const std::array<Point, 3> triangle{nodes_[node.previous].at, node.at, nodes_[node.next].at};
  uint32_t blocker = kNil;
  visit(0, triangle, [&](uint32_t other) {
    const Node& n = nodes_[other];
    if (other == ear || n.at == triangle[0] || n.at == triangle[2] || !inside(triangle, n.at)) return false;
    if (n.at == node.at) {
      // Another part of the outline touches this corner; it is in the way only if it comes out of the
      // triangle.
      const auto within = [&](const Point& q) {
        return orient(triangle[0], node.at, q) > 0 && orient(node.at, triangle[2], q) > 0;
      };
      if (!within(nodes_[n.previous].at) && !within(nodes_[n.next].at)) return false;
    }
    blocker = other;
    return true;
  });
  return blocker;
}

void Triangulator::enqueue(uint32_t node) {
  Node& n = nodes_[node];
  if (n.removed || n.active || n.queued) return;
  n.queued = true;
  queue_.push_back(node);
}

void Triangulator::wakeWatchers(uint32_t node) {
  for (uint32_t w = nodes_[node].watchers; w != kNil; w = watches_[w].next) enqueue(watches_[w].node);
  nodes_[node].watchers = kNil;
}

/// After a neighbour has changed. In the tree are the corners that are not convex: only they can be in an
/// ear.
void Triangulator::update(uint32_t node) {
  const bool convex = turn(node) > 0;
  setActive(node, !convex);
  if (!convex) return;
  wakeWatchers(node);
  enqueue(node);
}

void Triangulator::remove(uint32_t node) {
  Node& n = nodes_[node];
  setActive(node, false);
  n.removed = true;
  nodes_[n.previous].next = n.next;
  nodes_[n.next].previous = n.previous;
  wakeWatchers(node);
  update(n.previous);
  update(n.next);
}

bool Triangulator::clip(uint32_t start, std::vector<Triangle>& out) {
  // What is reachable from the outline is the polygon; holes that found no bridge stay out.
  size_t left = 0;
  uint32_t node = start;
  do {
    ++left;
    nodes_[node].active = turn(node) <= 0;
    node = nodes_[node].next;
  } while (node != start);
  buildTree();
  watches_.clear();
  queue_.clear();
  do {
    enqueue(node);
    node = nodes_[node].next;
  } while (node != start);

  bool simple = true;
  uint32_t cursor = start;
  size_t head = 0;
  while (left > 2) {
    if (head == queue_.size()) {
      simple = clipStuck(cursor, out) && simple;
      --left;
      continue;
    }
    const uint32_t ear = queue_[head++];
    if (head > 4096 && 2 * head > queue_.size()) {
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<ptrdiff_t>(head));
      head = 0;
    }
    nodes_[ear].queued = false;
    if (nodes_[ear].removed || nodes_[ear].active) continue;
    if (const uint32_t blocker = findBlocker(ear); blocker != kNil && left > 3) {
      watches_.push_back({ear, nodes_[blocker].watchers});
      nodes_[blocker].watchers = static_cast<uint32_t>(watches_.size() - 1);
      continue;
    }
    const Node& n = nodes_[ear];
    out.push_back({nodes_[n.previous].point, n.point, nodes_[n.next].point});
    cursor = n.next;
    remove(ear);
    --left;
  }
  return simple && work_ <= workLimit_;
}

/// No corner is an ear: what is left has no area, or crosses itself. Takes away a flat corner if there is one
/// near, else clips a convex one unseen. False: something went wrong before.
bool Triangulator::clipStuck(uint32_t& cursor, std::vector<Triangle>& out) {
  constexpr int kSteps = 64;
  uint32_t choice = cursor, node = cursor;
  double best = turn(cursor);
  for (int i = 0; i < kSteps && best != 0; ++i, node = nodes_[node].next) {
    const double t = turn(node);
    if (t == 0 || (t > 0 && best < 0)) choice = node, best = t;
  }
  const Node& n = nodes_[choice];
  if (best > 0) out.push_back({nodes_[n.previous].point, n.point, nodes_[n.next].point});
  cursor = n.next;
  remove(choice);
  return best == 0;
}

// ---- Holes
// -------------------------------------------------------------------------------------------------------

size_t Triangulator::strip(double y) const {
  const double s = (y - stripOrigin_) * stripScale_;
  return std::min(static_cast<size_t>(std::max(s, 0.0)), strips_.size() - 1);
}

void Triangulator::addEdge(uint32_t a, uint32_t b) {
  const auto [low, high] = std::minmax(nodes_[a].at.y, nodes_[b].at.y);
  for (size_t s = strip(low); s <= strip(high); ++s) {
    strips_[s].push_back({a, b});
    ++work_;
  }
}

/// Joins the holes to the outline from left to right: what is left of a hole's leftmost point has been joined
/// before.
bool Triangulator::bridgeHoles(std::span<Hole> holes, uint32_t outlineEnd) {
  // Rows of edges, so many that an average edge is in few of them.
  double low = nodes_[0].at.y, high = low, length = 0;
  for (const Node& n : nodes_) {
    low = std::min(low, n.at.y);
    high = std::max(high, n.at.y);
    length += std::abs(n.at.y - nodes_[n.next].at.y);
  }
  const auto count = static_cast<double>(nodes_.size());
  const double crossings = high > low ? length / (high - low) : count;
  strips_.assign(static_cast<size_t>(std::clamp(4 * count / (crossings + 1), 1.0, count)), {});
  stripOrigin_ = low;
  stripScale_ = high > low ? static_cast<double>(strips_.size()) / (high - low) : 0;

  // Edges and vertices count once their loop is joined.
  buildTree();
  const auto join = [&](uint32_t first, uint32_t end) {
    for (uint32_t n = first; n < end; ++n) setActive(n, true);
    for (uint32_t n = first; n < end; ++n) addEdge(n, nodes_[n].next);
  };
  join(0, outlineEnd);
  std::sort(holes.begin(), holes.end(), [&](const Hole& a, const Hole& b) {
    const Point &p = nodes_[a.leftmost].at, &q = nodes_[b.leftmost].at;
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : a.leftmost < b.leftmost;
  });
  bool simple = true;
  for (const Hole& hole : holes) {
    const uint32_t from = work_ > workLimit_ ? kNil : findVisible(hole.leftmost);
    if (from == kNil) {
      simple = false;
      continue;
    }
    join(hole.first, hole.end);
    const uint32_t bridge = addBridge(from, hole.leftmost);
    addEdge(bridge, hole.leftmost);
  }
  for (Node& n : nodes_) n.active = false;
  return simple;
}

/// A joined vertex that the leftmost vertex of a hole sees.
uint32_t Triangulator::findVisible(uint32_t hole) const {
  // The nearest edge straight to the left, and its left end.
  const Point h = nodes_[hole].at;
  double hit = -std::numeric_limits<double>::infinity();
  uint32_t best = kNil;
  for (const auto& [a, b] : strips_[strip(h.y)]) {
    ++work_;
    const Point &p = nodes_[a].at, &q = nodes_[b].at;
    if ((p.y <= h.y) == (q.y <= h.y)) continue;
    const double x = p.x + (h.y - p.y) / (q.y - p.y) * (q.x - p.x);
    if (x > h.x || x <= hit) continue;
    hit = x;
    best = p.x < q.x ? a : b;
  }
  if (best == kNil) return kNil;

  // Vertices between the ray and that end hide it; the one nearest to the ray in angle is seen.
  const Point end = nodes_[best].at, onEdge(hit, h.y);
  std::array<Point, 3> triangle{h, onEdge, end};
  if (orient(h, onEdge, end) < 0) std::swap(triangle[1], triangle[2]);
  const auto slope = [&](const Point& p) {
    return p == h      ? -1.0
           : h.x > p.x ? std::abs(p.y - h.y) / (h.x - p.x)
                       : std::numeric_limits<double>::infinity();
  };
  double least = slope(end);
  visit(0, triangle, [&](uint32_t other) {
    const Point& p = nodes_[other].at;
    if (p.x < std::min(end.x, hit) || p.x > h.x || !inside(triangle, p)) return false;
    const double s = slope(p);
    if (s < least || (s == least && p.x > nodes_[best].at.x)) least = s, best = other;
    return false;
  });

  // Of the corners at that point, the one whose angle holds the bridge.
  for (uint32_t n = best; n != kNil; n = nodes_[n].copy) {
    const Point &a = nodes_[nodes_[n].previous].at, &m = nodes_[n].at, &c = nodes_[nodes_[n].next].at;
    const bool first = orient(a, m, h) > 0, second = orient(m, c, h) > 0;
    if (orient(a, m, c) > 0 ? first && second : first || second) return n;
  }
  return best;
}

/// Opens both loops at the bridge; returns the outline's end of it.
uint32_t Triangulator::addBridge(uint32_t from, uint32_t hole) {
  const auto secondFrom = static_cast<uint32_t>(nodes_.size()), secondHole = secondFrom + 1;
  Node f = nodes_[from], h = nodes_[hole];
  nodes_[from].copy = secondFrom;
  nodes_[hole].copy = secondHole;
  nodes_[from].next = hole;
  nodes_[hole].previous = from;
  nodes_[h.previous].next = secondHole;
  h.next = secondFrom;
  f.previous = secondHole;
  nodes_[f.next].previous = secondFrom;
  nodes_.push_back(f);
  nodes_.push_back(h);
  return from;
}

}  // namespace patina
