// SPDX-License-Identifier: Apache-2.0
// RI's graphics state while a scene is being built: what AttributeBegin saves, and the blocks that are open.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "renderer/scene/scene.h"
#include "rib/archives.h"

namespace patina {

/// The solid that primitives are a part of.
struct SolidPlace {
  uint32_t solid = kNone;     ///< index of the open world's or object's solids; kNone: not in a solid
  uint32_t node = 0;          ///< the innermost SolidBegin
  size_t firstPrimitive = 0;  ///< that may be a part of the solid
  bool operator==(const SolidPlace&) const = default;
};

/// What AttributeBegin saves and AttributeEnd restores.
struct GraphicsState {
  Attributes attributes;
  uint32_t stored = kNone;  ///< index of these attributes in Scene::attributes; kNone: they changed since
  bool touched = true;      ///< an attribute was set since ObjectBegin
  M44d ctm;         ///< to world inside a world block, to the object inside an object, to camera elsewhere
  Movement moving;  ///< of ctm, which is that of the shutter's opening; still for the most part

  /// The current orientation differs from the handedness of the current coordinate system. A transformation
  /// with a negative determinant flips both (RI 3.2, Orientation), so only orientation requests change this.
  bool inside = false;
  bool lightsCastShadows = true;  ///< Attribute "light" "shadows"
  std::optional<Rgb> bxdfColor;   ///< the modern dialect's surface colour stands in for Color

  CubicBasis basisU, basisV;
  bool roundCurves = false;                ///< Attribute "dice" "roundcurve"
  std::shared_ptr<const TrimRegion> trim;  ///< TrimCurve; null = none
  bool trimOutside = false;                ///< Attribute "trimcurve" "sense" "outside"
  float detail = kInfinity;                ///< area in pixels of the Detail bound
  std::array<float, 4> detailRange{0, 0, kInfinity, kInfinity};
  SolidPlace solid;
  bool operator==(const GraphicsState&) const = default;
};

/// What a delayed archive finds when it is read, but for its transformation. Requests under equal states
/// share one.
struct DelayedState {
  GraphicsState state;                                ///< ctm is the identity
  Archives::Chain chain;                              ///< the files that were being read at the request
  std::vector<std::pair<std::string, M44d>> systems;  ///< ScopedCoordinateSystem: names and what they mean
  bool operator==(const DelayedState&) const = default;
};

enum class BlockKind : uint8_t { Frame, World, Attribute, Transform, Solid, Object, Motion, Resource };
inline constexpr size_t kBlockKinds = 8;

/// The request that opens a block, without "Begin".
std::string_view name(BlockKind kind);

/// The open blocks, innermost last. Every operation takes constant time, however deep the nesting.
class BlockStack {
 public:
  struct Block {
    BlockKind kind;
    Location where;
    int outer;  ///< index of the next open block of the same kind, -1 = none
  };

  bool empty() const { return blocks_.empty(); }
  size_t depth() const { return blocks_.size(); }
  const Block& top() const { return blocks_.back(); }
  bool isOpen(BlockKind kind) const { return last(kind) >= 0; }

  void push(BlockKind kind, const Location& where);
  Block pop();

  /// Whether an End of this kind has a Begin that it may close: World, Object and Frame blocks hide what is
  /// around them.
  bool mayClose(BlockKind kind) const;

 private:
  int last(BlockKind kind) const { return last_[static_cast<size_t>(kind)]; }

  std::vector<Block> blocks_;
  std::array<int, kBlockKinds> last_{-1, -1, -1, -1, -1, -1, -1, -1};
};

}  // namespace patina
