// SPDX-License-Identifier: Apache-2.0
// Opacity of surfaces that only their shaders know - cut-outs, leaves, filters - at the vertices of patches,
// in a multiresolution cache like that of radiosity (Christensen et al. 2012, sections 3 and 5): shadow and
// diffuse rays that pass through a patch at the same level share what its shader was asked once.
//
// Opacity does not depend on what is around a surface, nor on how often light has bounced: the key is patch,
// side and level, values are never missing, and a ray need not be longer than vertices are apart.
//
// Every result is a function of its arguments and of the scene: neither threads, nor what happens to be
// cached, change a bit of it.
#pragma once

#include <memory>
#include <mutex>
#include <span>

#include "renderer/cache/fill_claims.h"
#include "renderer/cache/packed_opacity.h"
#include "renderer/cache/patch_cache.h"
#include "renderer/shading/surface_shading.h"

namespace patina {

class OpacityCache {
 public:
  /// `bytes`: reserved when the first look-up comes, so that scenes without any pay nothing. Both references
  /// must outlive the cache. [main]
  OpacityCache(const Geometry& geometry, const SurfaceShading& shading, size_t bytes);
  ~OpacityCache();

  /// A hit of a surface whose opacity is shaded (SurfaceShading::isOpacityShaded).
  struct Lookup {
    const Hit* hit;
    float footprint;  ///< width of the ray at the hit
    uint32_t user;    ///< whatever the caller likes
    bool found;       ///< false: the shader is to be asked at the hit
    Rgb opacity;      ///< in [0, 1]
  };
  /// Opacities at hits, from the cache or made and kept; those of rays narrower than a patch's vertices are
  /// apart, and of shaders that are not to be cached, are not found. Throws std::bad_alloc when the memory
  /// cannot be reserved. [any thread]
  void lookUp(std::span<Lookup> lookups) const;

  void report() const;  ///< figures that are known at the end only [main]
  /// Bytes reserved so far: 0 until the first look-up, and never more than the budget. [any thread]
  size_t capacity() const;

 private:
  using Table = PatchCacheOf<uint32_t>;
  struct Waiting;
  struct Want;
  struct Fill;
  struct Workspace;
  Table& table() const;
  bool tryLevel(Lookup& lookup, uint32_t patch, Level level, Waiting& x) const;
  void make(Workspace& w) const;
  bool takeFromCache(const Fill& fill, Workspace& w) const;
  void makeSome(Workspace& w) const;
  void addPoints(const Waiting& x, uint32_t vertex, Workspace& w) const;

  const Geometry& geometry_;
  const SurfaceShading& shading_;
  const size_t bytes_;
  mutable std::mutex tableMutex_;  ///< of making it
  mutable std::unique_ptr<Table> tableMade_;
  mutable std::atomic<Table*> table_ = nullptr;
  mutable FillClaims claims_;  ///< by Want::key
};

}  // namespace patina
