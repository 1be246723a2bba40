// SPDX-License-Identifier: Apache-2.0
// Look-ups of opacity, and the filling of what they miss: each value once for all look-ups of a batch.
#include "renderer/integrators/opacity_cache.h"

#include <fmt/format.h>

#include <thread>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/look-ups of opacity", lookupTime);
STAT_COUNTER("Opacity cache/points shaded", pointsShaded);
STAT_COUNTER("Opacity cache/look-ups answered", answered);
STAT_COUNTER("Opacity cache/look-ups left to the shader", unanswered);
STAT_COUNTER("Opacity cache/batches of fills", fillBatches);
STAT_COUNTER("Opacity cache/entries made by another thread meanwhile", madeByOthers);

struct LevelStatistics {
  StatCounter lookups, hits, misses;
};
constexpr std::array<const char*, kLevels> kLevelNames{"coarse", "medium", "fine"};

LevelStatistics& statisticsOf(Level level) {
  static const std::vector<std::unique_ptr<LevelStatistics>> all = [] {
    std::vector<std::unique_ptr<LevelStatistics>> made;
    for (const char* name : kLevelNames) {
      const std::string path = fmt::format("Opacity cache/{}/", name);
      made.push_back(std::make_unique<LevelStatistics>(LevelStatistics{
          StatCounter(path + "look-ups"), StatCounter(path + "hits"), StatCounter(path + "misses")}));
    }
    return made;
  }();
  return *all[static_cast<size_t>(level)];
}

/// A level is fine enough when its vertices are at most so many widths of the ray apart. Rays for which no
/// level is are left to the shader: interpolated at the fine level they would blur shadows. Measured on
/// tests/scenes/leaves at 120x80 without indirect light, as relMSE against path mode with 1024 samples, and
/// the share of the area light's rays that is left to the shader:
///   limit        0 (all shaded)  0.35     0.7      1        1.5      2        4        none
///   sun          0.0051          0.0047   0.0044   0.0044   0.0090   0.012    0.015    0.042
///   area light   0.00015         0.00012  0.00011  0.00015  0.00021  0.00035  0.00048  0.00082
///   left         100 %           86 %     52 %     30 %     14 %     5 %      0        0
constexpr float kLevelScale = 0.7f;
/// Values of the coarse and the medium level stand for so many cells along a patch, at least: a leaf that is
/// cut out of its patch has nothing at the patch's corners.
constexpr int kAveraged = 4;
constexpr size_t kPointsAtOnce = 8192;
constexpr uint8_t kDepth = 1;  // of the keys; the table gives up fine entries of depth 0 first

}  // namespace

/// A look-up that waits for values to be made.
struct OpacityCache::Waiting {
  uint32_t lookup;
  uint32_t patch;
  bool front;
  Level stored;
  uint8_t block;  ///< of the fine level
  bool counted;   ///< as a miss
  VertexWeights around;
  std::array<uint32_t, 4> inBlock;
  std::array<uint32_t, 4> codes;
};

/// Codes that something waits for: all of a patch's level, or one fine vertex.
struct OpacityCache::Want {
  uint64_t key;  ///< patch 32 | front 1 | level 2 | block 4 | vertex in the block 5
  uint32_t waiting;
  uint32_t corner;
  auto operator<=>(const Want&) const = default;
};

/// Wants of one key; points[firstPoint] ... are shaded for them.
struct OpacityCache::Fill {
  uint32_t firstWant, endWant;
  uint32_t firstPoint = 0;
};

struct OpacityCache::Workspace {
  std::vector<Waiting> waiting;
  std::vector<Want> wants;
  std::vector<Fill> fills, others;  // to be made here, and by other threads
  std::vector<ShadingPoint> points;
  ShadedPoints shaded;
};

OpacityCache::OpacityCache(const Geometry& geometry, const SurfaceShading& shading, size_t bytes)
    : geometry_(geometry), shading_(shading), bytes_(bytes) {}

OpacityCache::~OpacityCache() = default;

OpacityCache::Table& OpacityCache::table() const {
  if (Table* known = table_.load(std::memory_order_acquire)) return *known;
  const std::scoped_lock lock(tableMutex_);
  if (!tableMade_) {
    tableMade_ = std::make_unique<Table>(bytes_);
    table_.store(tableMade_.get(), std::memory_order_release);
  }
  return *tableMade_;
}

size_t OpacityCache::capacity() const {
  const Table* known = table_.load(std::memory_order_acquire);
  return known ? known->capacity() : 0;
}

namespace {

Rgb evaluate(const VertexWeights& around, const std::array<uint32_t, 4>& codes) {
  Rgb opacity(0, 0, 0);
  for (int k = 0; k < around.count; ++k)
    opacity += PackedOpacity::unpack(codes[static_cast<size_t>(k)]) * around.weight[k];
  return opacity;
}

}  // namespace

void OpacityCache::lookUp(std::span<Lookup> lookups) const {
  const TimeShare share(lookupTime);
  thread_local Workspace w;
  const PatchTable& patches = geometry_.patches();
  w.waiting.clear();
  size_t left = 0;
  for (uint32_t k = 0; k < lookups.size(); ++k) {
    Lookup& lookup = lookups[k];
    const Hit& hit = *lookup.hit;
    lookup.found = false;
    // The coarsest level whose vertices lie as close as the ray is wide.
    const float widest = lookup.footprint * kLevelScale;
    uint32_t index = kNone;
    if (!shading_.shaderOf(hit.placement).has(PATINA_TRAIT_NOT_CACHEABLE)) {
      index = patches.find(hit.placement, hit.face, hit.u, hit.v);
      if (patches[index].group > 0)
        for (uint32_t next = patches.coarser(index); next != kNone && patches[next].spacing <= widest;
             next = patches.coarser(index))
          index = next;
      if (patches[index].spacing > widest) index = kNone;
    }
    if (index == kNone) {
      ++left;
      continue;
    }
    const Patch& patch = patches[index];
    Level level = Level::Coarse;
    while (patch.spacingAt(level) > widest) level = static_cast<Level>(static_cast<int>(level) + 1);
    Waiting x;
    if (tryLevel(lookup, index, level, x)) continue;
    x.lookup = k;
    w.waiting.push_back(x);
  }
  unanswered += static_cast<int64_t>(left);
  answered += static_cast<int64_t>(lookups.size() - left);
  if (w.waiting.empty()) return;
  make(w);
  for (const Waiting& x : w.waiting) {
    lookups[x.lookup].found = true;
    lookups[x.lookup].opacity = evaluate(x.around, x.codes);
  }
}

/// Whether the cache knows; else `x` says what must be made.
bool OpacityCache::tryLevel(Lookup& lookup, uint32_t index, Level level, Waiting& x) const {
  const Hit& hit = *lookup.hit;
  const Patch& patch = geometry_.patches()[index];
  const V2f local = patch.toLocal(hit.u, hit.v);
  x.patch = index, x.front = hit.front, x.counted = false;
  x.stored = patch.canonical(level);
  x.around = patch.locate(x.stored, local.x, local.y);
  const auto count = static_cast<size_t>(x.around.count);
  x.block = 0;
  if (x.stored == Level::Fine)
    x.block = patch.blockOf(x.around, x.inBlock.data());
  else
    std::copy_n(x.around.index, count, x.inBlock.begin());
  LevelStatistics& statistics = statisticsOf(x.stored);
  ++statistics.lookups;
  if (!table().find({index, x.front, kDepth, x.block}, x.stored, {x.inBlock.data(), count}, x.codes.data()))
    x.codes.fill(PackedOpacity::kMissing);
  for (size_t i = 0; i < count; ++i)
    if (x.codes[i] == PackedOpacity::kMissing) return false;
  ++statistics.hits;
  lookup.found = true;
  lookup.opacity = evaluate(x.around, x.codes);
  return true;
}

/// Gives all that wait their codes: a fine vertex by itself, of the other levels all vertices. What another
/// thread is making already is left until the rest is made. (That thread waits for nobody that may wait for
/// this one: who makes opacities asks for nothing else.)
void OpacityCache::make(Workspace& w) const {
  w.wants.clear(), w.fills.clear(), w.others.clear(), w.points.clear();
  for (uint32_t k = 0; k < w.waiting.size(); ++k) {
    const Waiting& x = w.waiting[k];
    const uint64_t key = uint64_t{x.patch} << 12 | uint64_t{x.front} << 11 |
                         static_cast<uint64_t>(x.stored) << 9 | uint64_t{x.block} << 5;
    if (x.stored != Level::Fine)
      w.wants.push_back({key, k, 0});
    else
      for (uint32_t i = 0; i < static_cast<uint32_t>(x.around.count); ++i)
        if (x.codes[i] == PackedOpacity::kMissing) w.wants.push_back({key | x.inBlock[i], k, i});
  }
  std::sort(w.wants.begin(), w.wants.end());
  const auto makeNow = [&] {
    if (w.fills.empty()) return;
    makeSome(w);
    for (const Fill& fill : w.fills) claims_.giveBack(w.wants[fill.firstWant].key);
    w.fills.clear(), w.points.clear();
  };
  // False: it is another thread's.
  const auto take = [&](Fill fill) {
    const uint64_t key = w.wants[fill.firstWant].key;
    if (!claims_.claim(key)) return false;
    if (takeFromCache(fill, w)) {  // it was made between the look-up and the claim
      ++madeByOthers;
      claims_.giveBack(key);
      return true;
    }
    const Want& want = w.wants[fill.firstWant];
    Waiting& first = w.waiting[want.waiting];
    if (!first.counted) ++statisticsOf(first.stored).misses;
    first.counted = true;
    fill.firstPoint = static_cast<uint32_t>(w.points.size());
    addPoints(first, first.around.index[want.corner], w);
    w.fills.push_back(fill);
    if (w.points.size() >= kPointsAtOnce) makeNow();
    return true;
  };
  for (uint32_t begin = 0, end = 0; begin < w.wants.size(); begin = end) {
    while (end < w.wants.size() && w.wants[end].key == w.wants[begin].key) ++end;
    if (!take({begin, end})) w.others.push_back({begin, end});
  }
  makeNow();
  while (!w.others.empty()) {
    const size_t left = w.others.size();
    std::erase_if(w.others, [&](const Fill& fill) {
      if (!takeFromCache(fill, w)) return take(fill);
      ++madeByOthers;
      return true;
    });
    makeNow();
    if (w.others.size() == left) std::this_thread::yield();
  }
  // Those that found their values made by others.
  for (const Waiting& x : w.waiting)
    if (!x.counted) ++statisticsOf(x.stored).hits;
}

/// False: the entry is not there, or not all of it.
bool OpacityCache::takeFromCache(const Fill& fill, Workspace& w) const {
  for (uint32_t i = fill.firstWant; i < fill.endWant; ++i) {
    const auto& [ignored, index, corner] = w.wants[i];
    Waiting& x = w.waiting[index];
    const bool fine = x.stored == Level::Fine;
    const size_t first = fine ? corner : 0, count = fine ? 1 : static_cast<size_t>(x.around.count);
    if (!table().find({x.patch, x.front, kDepth, x.block}, x.stored, {&x.inBlock[first], count},
                      &x.codes[first]))
      x.codes[first] = PackedOpacity::kMissing;
    if (x.codes[first] == PackedOpacity::kMissing) return false;
  }
  return true;
}

namespace {

/// Calls visit(local uv) for the centres of cells of equal size that a patch is cut into, of which the
/// vertices of a level that is not fine are averages. What a shader says of a cell is of that cell alone:
/// around a vertex on a rim half would be off the surface, where a cut-out has nothing.
template <class Visit>
void forEachCell(const Patch& patch, Level level, Visit visit) {
  const int nu = std::max(patch.cellsAt(level, patch.cellsU), kAveraged);
  const int nv = std::max(patch.cellsAt(level, patch.cellsV), kAveraged);
  const bool quad = patch.shape == FaceShape::Quad;
  const auto at = [&](int i, int j, float in) {
    visit(V2f((static_cast<float>(i) + in) / static_cast<float>(nu),
              (static_cast<float>(j) + in) / static_cast<float>(nv)));
  };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < (quad ? nu : nu - j); ++i) {
      at(i, j, quad ? 0.5f : 1.0f / 3);
      if (!quad && i + j + 1 < nu) at(i, j, 2.0f / 3);
    }
}

/// (u, v) of a face for a fine vertex. One on the rim of the face stands for the half cell inside and is
/// moved to the middle of that: around the rim itself half would be off the surface.
V2f awayFromRim(const Patch& patch, V2f uv) {
  constexpr float kInset = 0.25f;
  if (patch.cellsU == 0) return uv;
  const float du = kInset * std::abs(patch.du) / static_cast<float>(patch.cellsU);
  const float dv = kInset * std::abs(patch.dv) / static_cast<float>(patch.cellsV);
  if (patch.shape == FaceShape::Quad) return {std::clamp(uv.x, du, 1 - du), std::clamp(uv.y, dv, 1 - dv)};
  const V3f b(std::max(1 - uv.x - uv.y, du), std::max(uv.x, du), std::max(uv.y, du));
  return V2f(b.y, b.z) / (b.x + b.y + b.z);
}

}  // namespace

/// The points that an entry is made from: one for a fine vertex; for other levels one for each cell.
void OpacityCache::addPoints(const Waiting& x, uint32_t vertex, Workspace& w) const {
  const Patch& patch = geometry_.patches()[x.patch];
  const auto add = [&](const V2f& uv, float footprint) {
    w.points.push_back(shading_.at(patch.placement, patch.face, uv.x, uv.y, x.front, footprint));
  };
  if (x.stored == Level::Fine)
    return add(awayFromRim(patch, patch.toFace(patch.vertexPosition(Level::Fine, vertex))),
               patch.spacingAt(Level::Fine));
  const float footprint = patch.spacingAt(Level::Coarse) / kAveraged;
  forEachCell(patch, x.stored, [&](const V2f& local) { add(patch.toFace(local), footprint); });
}

void OpacityCache::makeSome(Workspace& w) const {
  ++fillBatches;
  pointsShaded += static_cast<int64_t>(w.points.size());
  shading_.shade(w.points, ShadingParts::Opacity, w.shaded);
  const PatchTable& patches = geometry_.patches();
  std::array<uint32_t, kMaxBlockVertices> codes;
  for (size_t k = 0; k < w.fills.size(); ++k) {
    const Fill& fill = w.fills[k];
    const Want& want = w.wants[fill.firstWant];
    const Waiting& x = w.waiting[want.waiting];
    const CacheKey key{x.patch, x.front, kDepth, x.block};
    const auto opacityAt = [&](uint32_t point) { return w.shaded.terms[fill.firstPoint + point].opacity; };
    if (x.stored == Level::Fine) {
      // Vertices of one block follow each other.
      constexpr uint64_t kInBlock = 31;
      const auto blockOf = [&](size_t i) { return w.wants[w.fills[i].firstWant].key & ~kInBlock; };
      if (k == 0 || blockOf(k - 1) != blockOf(k)) codes.fill(PackedOpacity::kMissing);
      const uint32_t code = codes[want.key & kInBlock] = PackedOpacity::pack(opacityAt(0));
      if (k + 1 == w.fills.size() || blockOf(k + 1) != blockOf(k)) table().store(key, Level::Fine, codes);
      for (uint32_t i = fill.firstWant; i < fill.endWant; ++i)
        w.waiting[w.wants[i].waiting].codes[w.wants[i].corner] = code;
      continue;
    }
    // Each vertex gets the mean of the cells around it, weighted as it is between vertices: so the mean over
    // the patch stays what it is.
    const Patch& patch = patches[x.patch];
    const uint32_t count = patch.vertexCount(x.stored);
    std::array<Rgb, kMaxBlockVertices> sums;
    std::array<float, kMaxBlockVertices> weights{};
    sums.fill(Rgb(0, 0, 0));
    uint32_t cell = 0;
    forEachCell(patch, x.stored, [&](const V2f& at) {
      const VertexWeights around = patch.locate(x.stored, at.x, at.y);
      Rgb opacity = opacityAt(cell++);
      for (int c = 0; c < 3; ++c) opacity[c] = std::clamp(opacity[c], 0.0f, 1.0f);
      for (int i = 0; i < around.count; ++i) {
        sums[around.index[i]] += opacity * around.weight[i];
        weights[around.index[i]] += around.weight[i];
      }
    });
    for (uint32_t v = 0; v < count; ++v)
      codes[v] = PackedOpacity::pack(weights[v] > 0 ? sums[v] / weights[v] : Rgb(0, 0, 0));
    table().store(key, x.stored, std::span(codes).first(count));
    for (uint32_t i = fill.firstWant; i < fill.endWant; ++i) {
      Waiting& to = w.waiting[w.wants[i].waiting];
      for (size_t c = 0; c < static_cast<size_t>(to.around.count); ++c)
        to.codes[c] = codes[to.around.index[c]];
    }
  }
}

void OpacityCache::report() const {
  const Table* known = table_.load();
  if (!known) return;
  for (int k = 0; k < kLevels; ++k) {
    const auto level = static_cast<Level>(k);
    const std::string path = fmt::format("Opacity cache/{}/", kLevelNames[static_cast<size_t>(k)]);
    const Table::Use use = known->use(level, kDepth);
    setStatistic(path + "slots", static_cast<double>(known->slots(level)));
    setStatistic(path + "bytes per slot", static_cast<double>(known->bytesPerSlot(level)));
    setStatistic(path + "entries", static_cast<double>(use.entries));
    setStatistic(path + "bytes", static_cast<double>(use.bytes));
    setStatistic(path + "evictions", static_cast<double>(use.evictions));
  }
  setStatistic("Opacity cache/bytes reserved", static_cast<double>(known->capacity()));
  setStatistic("Opacity cache/bytes in memory", static_cast<double>(known->resident()));
  setStatistic("Opacity cache/shader points saved",
               static_cast<double>(answered.total() - pointsShaded.total()));
}

}  // namespace patina
