// SPDX-License-Identifier: Apache-2.0
// Look-ups in the cache, and the filling of what they miss: each entry once for all look-ups of a batch.
#include <thread>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/look-ups of radiosity", lookupTime);
STAT_TIME("Time of threads/waiting for values that other threads make", waitTime);
STAT_TIME("Time of threads/everything else", otherTime);
STAT_COUNTER("Radiosity/points shaded from the cache's vertices", vertexPoints);
STAT_COUNTER("Radiosity/batches of fills", fillBatches);
STAT_COUNTER("Radiosity cache/rays/met something", rayLookups);
STAT_COUNTER("Radiosity cache/rays/found their value", rayFound);
STAT_COUNTER("Radiosity cache/rays/shaded, as the shader is not cacheable", rayNotCacheable);
STAT_COUNTER("Radiosity cache/rays/shaded, as they are too short", rayShort);
STAT_COUNTER("Radiosity cache/rays/shaded, as they are too narrow", rayNarrow);
STAT_COUNTER("Radiosity cache/rays/shaded, as they are the last ones and meet small faces", rayLast);
STAT_COUNTER("Radiosity cache/rays/shaded, as something stands in the cell", raySeparated);
STAT_COUNTER("Radiosity/entries made by another thread meanwhile", madeByOthers);

/// Of a key, the vertex of the fine level.
constexpr uint64_t kInBlock = 31;

constexpr Level finer(Level level) { return static_cast<Level>(static_cast<int>(level) + 1); }

/// Of Settings::fineScale for look-ups that few others are averaged with.
constexpr float kStrictScale = 1;

/// A vertex is worth rays by the root of how often it is met, which goes with the micropolygons that are its
/// share: that balances what its noise and what its rays cost.
Purpose purposeOf(const Patch& patch, Level level) {
  if (level == Level::Fine || patch.group == 1) return Purpose::FineVertex;
  if (patch.group > 1) return patch.group == 2 ? Purpose::HalfVertex : Purpose::Vertex;
  const uint32_t cells = uint32_t{patch.cellsU} * patch.cellsV / (patch.shape == FaceShape::Quad ? 1 : 2),
                 vertices = patch.vertexCount(level);
  return cells >= 32 * vertices  ? Purpose::Vertex
         : cells >= 8 * vertices ? Purpose::HalfVertex
         : cells >= 2 * vertices ? Purpose::QuarterVertex
                                 : Purpose::FineVertex;
}

}  // namespace

/// False: something stands in the cell.
bool RadiosityEngine::evaluate(const VertexWeights& around, const uint64_t* codes, Rgb& radiance) {
  radiance = Rgb(0, 0, 0);
  for (int k = 0; k < around.count; ++k) {
    if (codes[k] == PackedRgb::kMissing) return false;
    radiance += PackedRgb::unpack(codes[k]) * around.weight[k];
  }
  return true;
}

void RadiosityEngine::lookUp(std::span<Lookup> lookups, int depth, int nesting) const {
  if (!cache_ || depth > kCachedDepths) return;
  const TimeShare share(lookupTime);
  Workspace& w = workspace(nesting);
  const PatchTable& patches = world_.geometry().patches();
  w.waiting.clear(), w.placed.clear(), w.fineCells.clear();
  std::array<int64_t, kLevels> asked{}, hits{};
  // So many look-ups wait for memory together.
  constexpr size_t kTogether = 64;
  const auto settle = [&] {
    for (Workspace::Placed& p : w.placed) {
      cache_->locate(p.probe, p.x.inBlockOf());
      if (p.cell != kNone) cache_->locate(p.standing, {&w.fineCells[p.cell].index, 1});
    }
    for (const Workspace::Placed& p : w.placed) {
      Waiting x = p.x;
      if (p.cell != kNone) {
        Workspace::FineCell& cell = w.fineCells[p.cell];
        if (!cache_->read(p.standing, {&cell.index, 1}, &cell.code)) cell.code = PackedRgb::kMissing;
      }
      const bool known = cache_->read(p.probe, x.inBlockOf(), x.codes.data());
      ++asked[static_cast<size_t>(x.stored)];
      survey(x, depth);
      const Settled settled = take(lookups[x.lookup], x, known, w.waiting);
      hits[static_cast<size_t>(x.stored)] += settled != Settled::Waits;
      if (settled == Settled::GoesFiner)
        tryLevels(lookups, x.lookup, x.patch, finer(x.level), depth, w, w.waiting);
    }
    w.placed.clear();
  };
  rayLookups += static_cast<int64_t>(lookups.size());
  int64_t tried = 0, found = 0;
  for (uint32_t k = 0; k < lookups.size(); ++k) {
    const Hit& hit = *lookups[k].hit;
    if (world_.shading().shaderOf(hit.placement).has(PATINA_TRAIT_NOT_CACHEABLE)) {
      ++rayNotCacheable;
      continue;
    }
    uint32_t index = patches.find(hit.placement, hit.face, hit.u, hit.v);
    // The coarsest level whose vertices lie as close as the ray is wide, and closer than the ray is long.
    const float widest = std::min(lookups[k].footprint * settings_.levelScale, hit.t);
    // Where there is none the finest may still do; but displaced surfaces push through themselves, and what
    // is hidden between two vertices nobody has looked for there.
    const float fineScale =
        lookups[k].strict ? std::min(settings_.fineScale, kStrictScale) : settings_.fineScale;
    const float wide =
        isDisplaced(hit.placement) ? widest : std::min(lookups[k].footprint * fineScale, hit.t);
    // Groups of faces have one value each: their levels are the groups that they are in.
    if (patches[index].group > 0)
      for (uint32_t next = patches.coarser(index); next != kNone && patches[next].spacing <= widest;
           next = patches.coarser(index))
        index = next;
    const Patch& patch = patches[index];
    if (patch.spacing > wide) {
      ++(patch.spacing > hit.t ? rayShort : rayNarrow);
      continue;
    }
    // The finest groups are so many that a ray seldom finds one that another has made: they pay only where
    // their values save further bounces.
    if (patch.group == 1 && lookups[k].bounces <= 0) {
      ++rayLast;
      continue;
    }
    ++tried;
    Level level = Level::Coarse;
    while (level != Level::Fine && patch.spacingAt(level) > widest) level = finer(level);
    Workspace::Placed& p = w.placed.emplace_back();
    const size_t cells = w.fineCells.size();
    const CacheKey key = place(lookups[k], k, index, level, depth, w, p.x);
    p.probe = cache_->probe(key, p.x.stored);
    p.cell = w.fineCells.size() > cells ? static_cast<uint32_t>(cells) : kNone;
    if (p.cell != kNone) p.standing = cache_->probe(standingKey(w.fineCells.back()), Level::Fine);
    if (w.placed.size() == kTogether) settle();
  }
  settle();
  for (int level = 0; level < kLevels; ++level) {
    CacheStatistics& statistics = cacheStatistics(static_cast<Level>(level), depth);
    statistics.lookups += asked[static_cast<size_t>(level)];
    statistics.hits += hits[static_cast<size_t>(level)];
  }
  while (!w.waiting.empty()) {
    make(w.waiting, depth, nesting);
    w.again.clear();
    for (const Waiting& x : w.waiting) {
      Lookup& lookup = lookups[x.lookup];
      lookup.found = evaluate(x.around, x.codes.data(), lookup.radiance);
      if (!lookup.found && x.level != Level::Fine)
        tryLevels(lookups, x.lookup, x.patch, finer(x.level), depth, w, w.again);
    }
    w.waiting.swap(w.again);
  }
  if (!w.fineCells.empty()) leaveSeparated(lookups, nesting);
  for (Lookup& lookup : lookups) {
    lookup.truth = lookup.found ? 0 : 1;
    found += lookup.found;
  }
  rayFound += found, raySeparated += tried - found;
}

void RadiosityEngine::blurred(std::span<Blurred> places) const {
  if (!cache_) return;
  Workspace& w = workspace(0);
  w.lookups.clear();
  for (uint32_t k = 0; k < places.size(); ++k)
    w.lookups.push_back({places[k].hit, places[k].bounces, places[k].footprint, k, true});
  lookUp(w.lookups, 1, 0);
  for (const Lookup& lookup : w.lookups)
    places[lookup.user].found = lookup.found, places[lookup.user].radiance = lookup.radiance;
}

void RadiosityEngine::correct(Lookup& lookup, float chance, uint64_t seed) {
  if (!lookup.found || chance <= 0) return;
  constexpr uint64_t kResidualStream = 0x7265;
  if (toUnit(static_cast<uint32_t>(hashOf(seed, kResidualStream) >> 32)) >= chance) return;
  lookup.truth = 1 / chance;
}

/// Where the value of a look-up at a level is; notes which cell of the fine level it is in.
CacheKey RadiosityEngine::place(const Lookup& lookup, uint32_t k, uint32_t index, Level level, int depth,
                                Workspace& w, Waiting& x) const {
  const Hit& hit = *lookup.hit;
  const Patch& patch = world_.geometry().patches()[index];
  const V2f local = patch.toLocal(hit.u, hit.v);
  x.lookup = k, x.patch = index, x.front = hit.front, x.level = level, x.counted = false;
  x.stored = patch.canonical(level);
  x.around = patch.locate(x.stored, local.x, local.y);
  x.block = 0;
  if (x.stored == Level::Fine) {
    x.block = patch.blockOf(x.around, x.inBlock.data());
    // The upper triangle of a square begins above and to the right: its place is that of the lower one.
    const bool upper = x.around.count == 3 && x.around.index[1] < x.around.index[0];
    const uint32_t at = upper ? x.inBlock[2] - 1 : x.inBlock[0];
    if (x.around.count >= 3)
      w.fineCells.push_back({index, hit.front, x.block, upper, at, k, x.around, PackedRgb::kMissing});
  } else {
    std::copy_n(x.around.index, x.around.count, x.inBlock.begin());
  }
  x.bounces = keptBounces(lookup.bounces);
  return {index, hit.front, static_cast<uint8_t>(depth), x.block, x.bounces};
}

uint64_t RadiosityEngine::entryKey(const Waiting& x, int depth) {
  return uint64_t{x.bounces} << 48 | static_cast<uint64_t>(depth) << 44 | uint64_t{x.patch} << 12 |
         uint64_t{x.front} << 11 | static_cast<uint64_t>(x.stored) << 9 | uint64_t{x.block} << 5;
}

/// Notes which values are asked for.
void RadiosityEngine::survey(const Waiting& x, int depth) const {
  uint32_t values = 0;
  for (const uint32_t index : x.inBlockOf()) values |= 1u << index;
  survey_.asked(entryKey(x, depth), values);
}

/// Takes the value if it is `known`, or has it wait to be made.
RadiosityEngine::Settled RadiosityEngine::take(Lookup& lookup, Waiting& x, bool known,
                                               std::vector<Waiting>& waiting) {
  if (!known) x.codes.fill(PackedRgb::kMissing);
  lookup.found = known && evaluate(x.around, x.codes.data(), lookup.radiance);
  // What is missing of the fine level was not made; of the others, something stands there.
  if (!lookup.found && (!known || x.stored == Level::Fine)) {
    waiting.push_back(x);
    return Settled::Waits;
  }
  return lookup.found || x.level == Level::Fine ? Settled::Done : Settled::GoesFiner;
}

/// From `level` on: finds the value, or finds that it must be made, or, where something stands in the cells
/// of all levels, nothing.
void RadiosityEngine::tryLevels(std::span<Lookup> lookups, uint32_t k, uint32_t index, Level level, int depth,
                                Workspace& w, std::vector<Waiting>& waiting) const {
  for (;; level = finer(level)) {
    Waiting x;
    const CacheKey key = place(lookups[k], k, index, level, depth, w, x);
    CacheStatistics& statistics = cacheStatistics(x.stored, depth);
    ++statistics.lookups;
    survey(x, depth);
    const bool known = cache_->find(key, x.stored, x.inBlockOf(), x.codes.data());
    const Settled settled = take(lookups[k], x, known, waiting);
    if (settled != Settled::Waits) ++statistics.hits;
    if (settled != Settled::GoesFiner) return;
  }
}

/// Gives all that wait their codes. A fine vertex is made by itself, as few rays need it and a miss must not
/// cost a whole patch; of the other levels all vertices are. What another thread is making already is left
/// until the rest is made. (That thread may itself wait, but only for entries of larger depth, of which this
/// one has no claim then.)
void RadiosityEngine::make(std::vector<Waiting>& waiting, int depth, int nesting) const {
  Workspace& w = workspace(nesting);
  w.wants.clear(), w.fills.clear(), w.others.clear();
  for (uint32_t k = 0; k < waiting.size(); ++k) {
    const Waiting& x = waiting[k];
    const uint64_t key = entryKey(x, depth);
    if (x.stored != Level::Fine)
      w.wants.push_back({key, k, 0});
    else
      for (uint32_t i = 0; i < static_cast<uint32_t>(x.around.count); ++i)
        if (x.codes[i] == PackedRgb::kMissing) w.wants.push_back({key | x.inBlock[i], k, i});
  }
  std::sort(w.wants.begin(), w.wants.end());
  // Vertices whose irradiance is interpolated send no rays themselves.
  const int raysOfEach = depth == 0 && settings_.irradianceError > 0
                             ? 1
                             : settings_.rays.diffuse(depth == kIrradiance ? 0 : depth, Purpose::Vertex);
  // What is claimed is there for other threads when all that is made with it is: they should not wait long.
  constexpr size_t kParts = 16;
  const size_t most = pointsAtOnce(raysOfEach) /
                      (isAlone_ || world_.geometry().tessellations().isTight() ? size_t{1} : kParts);
  size_t vertices = 0;
  const auto makeNow = [&] {
    if (!w.fills.empty()) makeSome(w.fills, waiting, depth, nesting);
    for (const Fill& fill : w.fills) claims_.giveBack(w.wants[fill.firstWant].key);
    w.fills.clear();
    vertices = 0;
  };
  // False: it is another thread's.
  const auto take = [&](const Fill& fill) {
    const uint64_t key = w.wants[fill.firstWant].key;
    if (!claims_.claim(key)) return false;
    if (takeFromCache(fill, waiting, depth, nesting)) {  // it was made between the look-up and the claim
      ++madeByOthers;
      claims_.giveBack(key);
      return true;
    }
    Waiting& first = waiting[w.wants[fill.firstWant].waiting];
    if (!first.counted) ++cacheStatistics(first.stored, depth).misses;
    first.counted = true;
    w.fills.push_back(fill);
    vertices +=
        first.stored == Level::Fine ? 1 : world_.geometry().patches()[first.patch].vertexCount(first.stored);
    if (vertices >= most) makeNow();
    return true;
  };
  for (uint32_t begin = 0, end = 0; begin < w.wants.size(); begin = end) {
    while (end < w.wants.size() && w.wants[end].key == w.wants[begin].key) ++end;
    if (!take({begin, end, 0})) w.others.push_back({begin, end, 0});
  }
  makeNow();
  while (!w.others.empty()) {
    const TimeShare share(waitTime);
    const size_t left = w.others.size();
    std::erase_if(w.others, [&](const Fill& fill) {
      if (!takeFromCache(fill, waiting, depth, nesting)) return take(fill);
      ++madeByOthers;
      return true;
    });
    makeNow();
    if (w.others.size() == left) std::this_thread::yield();
  }
  // Those that found their values made by others.
  for (const Waiting& x : waiting)
    if (!x.counted) ++cacheStatistics(x.stored, depth).hits;
}

/// False: the entry is not there, or not all of it.
bool RadiosityEngine::takeFromCache(const Fill& fill, std::vector<Waiting>& waiting, int depth,
                                    int nesting) const {
  const Workspace& w = workspace(nesting);
  for (uint32_t i = fill.firstWant; i < fill.endWant; ++i) {
    const auto& [ignored, index, corner] = w.wants[i];
    Waiting& x = waiting[index];
    if (depth == kIrradiance) {
      if (findIrradiance(x)) continue;
      return false;
    }
    const CacheKey key{x.patch, x.front, static_cast<uint8_t>(depth), x.block, x.bounces};
    if (x.stored == Level::Fine) {
      if (!cache_->find(key, Level::Fine, {&x.inBlock[corner], 1}, &x.codes[corner]) ||
          x.codes[corner] == PackedRgb::kMissing) {
        x.codes[corner] = PackedRgb::kMissing;
        return false;
      }
    } else if (!cache_->find(key, x.stored, {x.inBlock.data(), static_cast<size_t>(x.around.count)},
                             x.codes.data())) {
      return false;
    }
  }
  return true;
}

void RadiosityEngine::makeSome(std::span<Fill> fills, std::vector<Waiting>& waiting, int depth,
                               int nesting) const {
  if (depth == kIrradiance) {
    makeIrradiance(fills, waiting, nesting);
    return;
  }
  const TimeShare share(otherTime);
  ++fillBatches;
  Workspace& w = workspace(nesting);
  const PatchTable& patches = world_.geometry().patches();
  w.fillRequests.clear(), w.pairOf.clear(), w.levelCorners.clear(), w.cornerPairs.clear(),
      w.codeOfCorner.clear();
  for (Fill& fill : fills) {
    const Want& want = w.wants[fill.firstWant];
    const Waiting& x = waiting[want.waiting];
    const auto first = static_cast<uint32_t>(w.fillRequests.size());
    fill.firstCode = first;
    if (x.stored == Level::Fine) {
      w.fillRequests.push_back(
          vertexRequest(x.patch, x.front, Level::Fine, x.around.index[want.corner], depth, x.bounces));
      continue;
    }
    const Patch& patch = patches[x.patch];
    const uint32_t count = patch.vertexCount(x.stored);
    for (uint32_t k = 0; k < count; ++k)
      w.fillRequests.push_back(vertexRequest(x.patch, x.front, x.stored, k, depth, x.bounces));
    if (count == 1) continue;
    const auto corner = static_cast<uint32_t>(w.levelCorners.size());
    for (uint32_t k = 0; k < count; ++k) {
      w.codeOfCorner.push_back({first + k, corner + k});
      w.levelCorners.push_back(cornerAt(x.patch, x.front, x.stored, k));
    }
    // Something may stand between a vertex and the centroid where it is shaded, too.
    patch.forEachDiagonal(x.stored, [&](uint32_t a, uint32_t b) {
      w.pairOf.push_back({first + a, first + b});
      w.cornerPairs.push_back({corner + a, corner + b});
    });
  }
  // Cells that something stands in are left to the finer level, or to shading at the hit.
  w.fillCodes.assign(w.fillRequests.size(), 0);
  cutAway(w.fillRequests, w.fillCodes, w);
  w.pairs.clear();
  for (const auto& [a, b] : w.cornerPairs) w.pairs.push_back({&w.levelCorners[a], &w.levelCorners[b]});
  w.separated.resize(w.pairs.size());
  blocked(w.pairs, kCover, w.separated, w);
  for (size_t k = 0; k < w.pairs.size(); ++k)
    if (w.separated[k]) w.fillCodes[w.pairOf[k][0]] = w.fillCodes[w.pairOf[k][1]] = PackedRgb::kMissing;
  // Displaced surfaces push through themselves: a centroid may be hidden though its vertex is not.
  w.pairs.clear();
  std::erase_if(w.codeOfCorner, [&](const std::array<uint32_t, 2>& at) {
    const auto& [code, corner] = at;
    return w.fillCodes[code] == PackedRgb::kMissing || !isDisplaced(w.levelCorners[corner].placement);
  });
  for (const auto& [code, corner] : w.codeOfCorner)
    w.pairs.push_back({&w.levelCorners[corner], &w.fillRequests[code].point});
  w.separated.resize(w.pairs.size());
  if (!w.pairs.empty()) hidden(w.pairs, w.separated, w);
  for (size_t k = 0; k < w.pairs.size(); ++k)
    if (w.separated[k]) w.fillCodes[w.codeOfCorner[k][0]] = PackedRgb::kMissing;

  for (size_t purpose = 0; purpose < w.shadeRequests.size(); ++purpose)
    w.shadeRequests[purpose].clear(), w.codeOf[purpose].clear();
  w.fillSpots.clear();
  for (size_t k = 0; k < fills.size(); ++k) {
    const Waiting& x = waiting[w.wants[fills[k].firstWant].waiting];
    const uint32_t end =
        k + 1 < fills.size() ? fills[k + 1].firstCode : static_cast<uint32_t>(w.fillCodes.size());
    const auto purpose = static_cast<size_t>(purposeOf(patches[x.patch], x.stored));
    for (uint32_t code = fills[k].firstCode; code < end; ++code) {
      if (w.fillCodes[code] == PackedRgb::kMissing) continue;
      w.shadeRequests[purpose].push_back(w.fillRequests[code]);
      w.codeOf[purpose].push_back(code);
      if (depth == 0 && settings_.irradianceError > 0)
        w.fillSpots.push_back(
            {x.patch, x.front, x.bounces, {{x.around.index[w.wants[fills[k].firstWant].corner]}, {1}, 1}});
    }
  }
  for (size_t purpose = 0; purpose < w.shadeRequests.size(); ++purpose) {
    const std::vector<Request>& requests = w.shadeRequests[purpose];
    if (requests.empty()) continue;
    vertexPoints += static_cast<int64_t>(requests.size());
    w.fillRadiance.resize(requests.size());
    shadeNested(requests, depth, static_cast<Purpose>(purpose), w.fillRadiance, nesting + 1, w.fillSpots);
    for (size_t k = 0; k < requests.size(); ++k)
      w.fillCodes[w.codeOf[purpose][k]] = PackedRgb::pack(w.fillRadiance[k]);
  }

  std::array<uint64_t, kMaxBlockVertices> block;
  for (size_t k = 0; k < fills.size(); ++k) {
    const Want& want = w.wants[fills[k].firstWant];
    const Waiting& x = waiting[want.waiting];
    const CacheKey key{x.patch, x.front, static_cast<uint8_t>(depth), x.block, x.bounces};
    const uint32_t first = fills[k].firstCode;
    const bool fine = x.stored == Level::Fine;
    survey_.made(entryKey(x, depth),
                 fine ? 1u << (want.key & kInBlock) : (1u << patches[x.patch].vertexCount(x.stored)) - 1);
    if (!fine) {
      cache_->store(key, x.stored,
                    std::span(w.fillCodes).subspan(first, patches[x.patch].vertexCount(x.stored)));
    } else {
      // Vertices of one block follow each other.
      const auto blockOf = [&](size_t i) { return w.wants[fills[i].firstWant].key & ~kInBlock; };
      if (k == 0 || blockOf(k - 1) != blockOf(k)) block.fill(PackedRgb::kMissing);
      block[want.key & kInBlock] = w.fillCodes[first];
      if (k + 1 == fills.size() || blockOf(k + 1) != blockOf(k)) cache_->store(key, Level::Fine, block);
    }
    for (uint32_t i = fills[k].firstWant; i < fills[k].endWant; ++i) {
      Waiting& to = waiting[w.wants[i].waiting];
      if (fine)
        to.codes[w.wants[i].corner] = w.fillCodes[first];
      else
        for (size_t c = 0; c < static_cast<size_t>(to.around.count); ++c)
          to.codes[c] = w.fillCodes[first + to.around.index[c]];
    }
  }
}

}  // namespace patina
