// SPDX-License-Identifier: Apache-2.0
// What a place sees of surfels: a small raster around it (Christensen 2008, section 6).
#pragma once

#include <functional>
#include <vector>

#include "renderer/points/point_tree.h"

namespace patina {

/// A hemicube (M. Cohen, D. Greenberg 1985, "The Hemi-Cube", section 3) over a place, into which far nodes
/// are drawn as squares of their projected area, surfels likewise, and near surfels by a ray through each
/// pixel. Of what a pixel sees the nearest counts first; parts of it that are covered add up until it is
/// full, as pieces of one surface lie beside each other. Memory of one thread, to be used again and again.
class PointRaster {
 public:
  struct Settings {
    int resolution = 16;          ///< pixels along an edge of the hemicube's top, 2 to 256, even
    float maxSolidAngle = 0.06f;  ///< steradians of a node's sphere, above which what is in it is looked at
  };
  explicit PointRaster(const Settings& settings);

  struct Estimate {
    Rgb irradiance{0, 0, 0};
    float covered = 0;          ///< cosine-weighted share of the hemisphere, 0 to 1
    float inverseDistance = 0;  ///< mean of 1 / distance, weighted likewise; of what is open 0
    float nearest = kInfinity;  ///< distance of what is seen
  };
  /// Radiance from where no surfel is, along unit directions away from the place; may be empty: none. Is
  /// called once at most.
  using Environment = std::function<void(std::span<const V3f> directions, std::span<Rgb> radiance)>;
  /// Irradiance at P on the side of N (unit; world space). `turn`, 0 to 1: the angle of the raster around N,
  /// for rasters of neighbours to differ. What is nearer than `nearest` is not seen.
  /// `lit` false: surfels are black, and only hide the environment.
  Estimate gather(const PointTree& tree, const V3f& P, const V3f& N, float turn, float nearest,
                  const Environment& environment, bool lit = true);

 private:
  struct Pixel {
    float weight;  ///< form factor: all sum up to 1
    V3f direction;
  };
  struct Item {
    float distance;
    float x, y, half;  ///< on its face, in pixels: where a square of its size is
    uint8_t face;
    Rgb radiance;
  };
  void look(const PointTree& tree, uint32_t node);
  void add(const V3f& local, float area, const Rgb& radiance);
  void trace(const Surfel& surfel);
  void trace(const PointTree::Plane& plane);
  /// Sets what pixels meet of a plane within a sphere: `isMet` says of a point of the plane whether it is.
  /// World space, relative to the place.
  template <class IsMet>
  void trace(const V3f& center, float radius, const V3f& on, const V3f& N, const Rgb& radiance, IsMet isMet);
  void draw(const Item& item);
  /// Pixels of a face: rows from y0 on stand in pixels_, the side faces' upper halves only.
  int rowsOf(int face) const { return face == 0 ? resolution_ : resolution_ / 2; }
  size_t firstOf(int face) const {
    const auto r = static_cast<size_t>(resolution_);
    return face == 0 ? 0 : r * r + static_cast<size_t>(face - 1) * r * (r / 2);
  }

  int resolution_;
  float maxSolidAngle_;
  std::vector<Pixel> pixels_;
  struct Content {
    Rgb radiance{0, 0, 0}, met{0, 0, 0};
    float covered = 0, inverse = 0;  ///< inverse: covered / distance
    float t = kInfinity;             ///<  of the nearest surfel that the pixel's ray meets
  };
  bool isOwn(const Surfel& surfel, float distance2, float height) const;
  static bool isFull(const Content& c);
  bool isBetweenFull(int face, int row, int column) const;
  std::vector<V3f> directions_;             ///< by pixel: world space
  std::array<std::array<V3f, 3>, 5> axes_;  ///< of faces: the way out, u and v
  std::vector<Content> content_;
  std::vector<Item> items_;
  std::vector<V3f> openDirections_;
  std::vector<float> openWeights_;
  std::vector<Rgb> openRadiance_;
  V3f P_{0, 0, 0};
  Frame frame_{V3f(0, 0, 1)};
  float nearest_ = 0;
};

}  // namespace patina
