// SPDX-License-Identifier: Apache-2.0
// An open texture, of one file or of a pattern of tiles, and look-ups in it.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "patina/shader.h"
#include "renderer/shading/texture_module.h"
#include "rib/error.h"

/// Immutable but for its counts. [any thread]
struct PatinaTexture {
  const PatinaTextureModule* module = nullptr;
  void* system = nullptr;
  PatinaTextureInfo file{};  ///< of a pattern: its first tile
  /// Of a pattern: row by row, without a handle where there is no file; empty: one file.
  std::vector<PatinaTextureInfo> tiles;
  uint32_t columns = 0, rows = 0;
  std::string name;
  patina::Location where;

  /// Look-ups that could not be made; of the first failure the reason.
  std::atomic<uint64_t> failed{0};
  std::mutex mutex;  // of what follows
  std::string reason;
  /// Look-ups where the pattern has no file, by column and row. At most kNamedTiles of them are told apart.
  std::map<std::pair<int64_t, int64_t>, uint64_t> missing;
  uint64_t missingElsewhere = 0;
  static constexpr size_t kNamedTiles = 64;
};

namespace patina {

/// `color` and `alpha` (which may be nullptr) of `count` lanes; PATINA_ERROR_RESOURCE: some could not be
/// read, are 1, and have been counted.
PatinaStatus lookUpFile(PatinaTexture& texture, const PatinaTextureInfo& file, uint32_t count,
                        const PatinaTextureLookup& in, PatinaOut3 color, float* alpha);

/// The same over a pattern of tiles: column floor(s), row floor(t) from t = 0 on, with its top row at the
/// lesser t. Below zero t counts upwards, as 1 - v of a v that points upwards does: [-1, 0) is row 1. A
/// filter that reaches over the edge of a tile is shared out among those that it covers, by area. Where there
/// is no tile, 1 is read and counted.
PatinaStatus lookUpTiles(PatinaTexture& texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                         PatinaPlane width, PatinaOut3 color, float* alpha);

}  // namespace patina
