// SPDX-License-Identifier: Apache-2.0
// Look-ups in one file, and in the tiles of a pattern, over their edges.
#include "renderer/shading/texture_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/base/statistics.h"

namespace patina {
namespace {

STAT_COUNTER("Textures/look-ups", textureLookups);
STAT_COUNTER("Textures/look-ups failed", failedLookups);
STAT_COUNTER("Textures/look-ups without a tile", missingLookups);

PatinaPlane one(const float& value) { return {&value, 0, 0}; }
float at(const PatinaPlane& plane, uint32_t i) { return plane.data ? plane.data[i * plane.stride] : 0.0f; }

const PatinaTextureInfo* tileAt(const PatinaTexture& texture, int64_t column, int64_t row) {
  if (column < 0 || row < 0 || column >= texture.columns || row >= texture.rows) return nullptr;
  const auto index = static_cast<size_t>(row) * texture.columns + static_cast<size_t>(column);
  return texture.tiles[index].handle ? &texture.tiles[index] : nullptr;
}

/// A filter's part within one tile, along one axis.
struct Part {
  int64_t cell;  // floor of the coordinate
  float center, width, weight;
};
/// The parts of [x - width / 2, x + width / 2], that of x first. `texel`: width of one, which is the least
/// that is shared out.
struct Parts {
  std::array<Part, 2> part;
  int count = 1;

  Parts(float x, float width, float texel) {
    const float cell = std::floor(x), inside = x - cell;
    part[0] = {static_cast<int64_t>(cell), inside, width, 1};
    const float reach = std::clamp(width, texel, 1.0f) / 2;
    const float low = inside - reach, high = inside + reach;
    if (low >= 0 && high <= 1) return;
    count = 2;
    const bool below = low < 0;
    const float own = below ? high / (2 * reach) : (1 - low) / (2 * reach);  // above 1/2
    const float other = (1 - own) * 2 * reach;                               // width of the part beyond
    part[0] = {part[0].cell, below ? high / 2 : (1 + low) / 2, own * 2 * reach, own};
    part[1] = {part[0].cell + (below ? -1 : 1), below ? 1 - other / 2 : other / 2, other, 1 - own};
  }
};

/// The row of a tile by the floor of t.
int64_t rowOf(int64_t cell) { return cell < 0 ? -cell : cell; }

}  // namespace

PatinaStatus lookUpFile(PatinaTexture& texture, const PatinaTextureInfo& file, uint32_t count,
                        const PatinaTextureLookup& in, PatinaOut3 color, float* alpha) {
  textureLookups += count;
  std::array<char, 512> error{};
  const uint32_t failed =
      texture.module->lookup(texture.system, &file, count, &in, color, alpha, error.data(), error.size());
  if (failed == 0) return PATINA_OK;
  failedLookups += failed;
  if (texture.failed.fetch_add(failed) == 0) {
    const std::scoped_lock lock(texture.mutex);
    texture.reason = error.data();
  }
  return PATINA_ERROR_RESOURCE;
}

PatinaStatus lookUpTiles(PatinaTexture& texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                         PatinaPlane width, PatinaOut3 color, float* alpha) {
  PatinaStatus status = PATINA_OK;
  for (uint32_t i = 0; i < count; ++i) {
    const auto give = [&](const std::array<float, 4>& value) {
      color.x[i] = value[0], color.y[i] = value[1], color.z[i] = value[2];
      if (alpha) alpha[i] = value[3];
    };
    // What no tile can have, NaN too, is column -1.
    constexpr float kFar = 1e6f;
    const float x = std::abs(at(s, i)) < kFar ? at(s, i) : -1, y = std::abs(at(t, i)) < kFar ? at(t, i) : 0;
    const float wide = std::abs(at(width, i));
    const int64_t column = static_cast<int64_t>(std::floor(x)), cell = static_cast<int64_t>(std::floor(y));
    const PatinaTextureInfo* const own = tileAt(texture, column, rowOf(cell));
    if (!own) {
      give({1, 1, 1, 1});
      ++missingLookups;
      const std::scoped_lock lock(texture.mutex);
      const std::pair place(column, rowOf(cell));
      if (texture.missing.size() < PatinaTexture::kNamedTiles || texture.missing.contains(place))
        ++texture.missing[place];
      else
        ++texture.missingElsewhere;
      continue;
    }
    const Parts across(x, wide, 1 / static_cast<float>(own->width));
    const Parts down(y, wide, 1 / static_cast<float>(own->height));
    std::array<float, 4> sum{};
    float weights = 0;
    for (int k = 0; k < across.count * down.count; ++k) {
      const auto& p = across.part[static_cast<size_t>(k % across.count)];
      const auto& q = down.part[static_cast<size_t>(k / across.count)];
      if (cell >= 0 && q.cell < 0) continue;  // nothing lies above a set whose t grows downwards
      const float weight = p.weight * q.weight;
      const PatinaTextureInfo* const tile = tileAt(texture, p.cell, rowOf(q.cell));
      if (!tile || !(weight > 0)) continue;
      std::array<float, 4> v{1, 1, 1, 1};
      const PatinaTextureLookup in{one(p.center), one(q.center),     one(p.width),
                                   one(q.width),  PATINA_WRAP_CLAMP, PATINA_WRAP_CLAMP};
      const PatinaStatus result = lookUpFile(texture, *tile, 1, in, {&v[0], &v[1], &v[2]}, &v[3]);
      if (result != PATINA_OK) status = result;
      for (size_t c = 0; c < 4; ++c) sum[c] += weight * v[c];
      weights += weight;
    }
    for (float& v : sum) v /= weights;
    give(sum);
  }
  return status;
}

}  // namespace patina
