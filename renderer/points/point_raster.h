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
    float maxSolidAngle = 0.03f;  ///< steradians of a node's sphere, above which what is in it is looked at
  };
  explicit PointRaster(const Settings& settings);

  struct Estimate {
    Rgb irradiance{0, 0, 0};
    float covered = 0;  ///< cosine-weighted share of the hemisphere, 0 to 1
  };
  /// Radiance from where no surfel is, along a unit direction away from the place; may be empty: none.
  using Environment = std::function<Rgb(const V3f& direction)>;
  /// Irradiance at P on the side of N (unit; world space). `turn`, 0 to 1: the angle of the raster around N,
  /// for rasters of neighbours to differ. What is nearer than `nearest` is not seen.
  Estimate gather(const PointTree& tree, const V3f& P, const V3f& N, float turn, float nearest,
                  const Environment& environment);

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
  void trace(const Surfel& surfel, const V3f& local);
  void trace(const PointTree::Plane& plane);
  /// Sets what pixels meet of a plane within a sphere: `isMet` says of a point of the plane, relative to the
  /// place and in the raster's axes, whether it is.
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
    float covered = 0, t = kInfinity;  ///< t: of the nearest surfel that the pixel's ray meets
  };
  static bool isFull(const Content& c);
  bool isBetweenFull(int face, int row, int column) const;
  std::vector<Content> content_;
  std::vector<Item> items_;
  V3f P_{0, 0, 0};
  Frame frame_{V3f(0, 0, 1)};
  float nearest_ = 0;
};

}  // namespace patina
