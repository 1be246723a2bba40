// SPDX-License-Identifier: Apache-2.0
// A hierarchy of lights, to pick one in proportion to a guess at what it gives to a point (Conty Estevez and
// Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"; PBR 4th ed. section 12.6.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/shading/light_bounds.h"

namespace patina {

/// Lights without a place, such as suns and skies, stand beside the tree. They and the tree have a fixed
/// share of half the chance, and one of the other half by what they seem to give to the point.
///
/// A light that may reach a point has a chance there, however small. Where none of those to choose from can,
/// as far as bounds tell, they are chosen by power, so that chances add up to one at every point.
///
/// Read-only once it is built. [any thread]
class LightTree {
 public:
  LightTree() = default;
  explicit LightTree(std::span<const LightBounds> lights);

  struct Pick {
    uint32_t light;  ///< index of what the tree was built from
    float chance;    ///< > 0
  };
  /// One light, of at least one, for u in [0, 1).
  Pick pick(const LightReceiver& at, float u) const;
  struct Picks {
    uint32_t light;
    float chance;    ///< of each pick
    uint32_t count;  ///< >= 1
  };
  /// What pick() gives for the n numbers (k + u) / n, each light once: sooner than one by one, as the tree is
  /// descended once. Of a light with chance p, n p picks are expected.
  void pickMany(const LightReceiver& at, uint32_t n, float u, std::vector<Picks>& out) const;
  /// That pick() gives the light; the same to the last bit.
  float chanceOf(const LightReceiver& at, uint32_t light) const;

  /// What a light of these bounds, of known power, seems to give: irradiance without shadows, roughly. 0 only
  /// where it cannot reach.
  static double importance(const LightBounds& light, const LightReceiver& at);

  size_t lights() const { return placeOf_.size(); }
  size_t nodes() const { return nodes_.size(); }
  bool operator==(const LightTree&) const = default;

 private:
  static constexpr size_t kFew = 8;  ///< lights that are chosen among one by one

  /// Bounds as the choice needs them.
  struct Cluster {
    V3f center{0, 0, 0}, axis{0, 0, 1};
    float radius = 0;  ///< of a sphere about the box
    float cosSpread = -1, sinSpread = 0, cosBeyond = 0;
    float strength = 0;
    bool twoSided = false;
    Cluster() = default;
    explicit Cluster(const LightBounds& bounds);
    /// Not inlined, so that pick() and chanceOf() round alike.
    [[gnu::noinline]] double importance(const LightReceiver& at) const;
    bool operator==(const Cluster&) const = default;
  };
  /// Its two children follow each other.
  struct Node {
    Cluster cluster;
    uint32_t first = 0, count = 0;  ///< in leaves_
    uint32_t child = 0;             ///< 0: none, its lights are chosen among one by one
    size_t options() const { return child ? 2 : count; }
    bool operator==(const Node&) const = default;
  };
  struct Builder;
  double besideShare(const LightReceiver& at) const;
  double weigh(const Node& node, const LightReceiver& at, std::span<double> weights) const;
  template <class Choose>
  double descend(const LightReceiver& at, Choose& choose) const;
  struct ByNumber;
  struct Towards;
  struct Spreading;

  std::vector<Node> nodes_;
  std::vector<Cluster> leaves_;     ///< lights with a place, in the order of the tree
  std::vector<uint32_t> lightAt_;   ///< by place: those of leaves_, then those beside the tree
  std::vector<uint32_t> placeOf_;   ///< by light
  std::vector<double> besideUpTo_;  ///< chance of those beside the tree among themselves, summed up
  double beside_ = 0;               ///< sum of their powers
};

}  // namespace patina
