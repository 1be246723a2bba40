// SPDX-License-Identifier: Apache-2.0
// What a place sees of surfels: a small raster around it (Christensen 2008, section 6).
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "renderer/points/surfel_view.h"

namespace patina {

/// A hemicube (M. Cohen, D. Greenberg 1985, "The Hemi-Cube", section 3) over a place, into which far nodes
/// are drawn as squares of their projected area, surfels likewise, and near surfels by a ray through each
/// pixel. Of what a pixel sees the nearest counts first; parts of it that are covered add up until it is
/// full, as pieces of one surface lie beside each other. Memory of one thread, to be used again and again.
class PointRaster {
 public:
  struct Settings {
    int resolution = 16;          ///< pixels along an edge of the hemicube's top, 2 to 256, even
    float maxSolidAngle = 0.25f;  ///< steradians of a node's sphere, above which what is in it is looked at
  };
  explicit PointRaster(const Settings& settings);

  struct Estimate {
    Rgb irradiance{0, 0, 0};
    float covered = 0;  ///< cosine-weighted share of the hemisphere, 0 to 1
    /// Mean of 1 / distance, weighted likewise, or with the light from there, whichever is larger; of what is
    /// open 0. Light of one lamp changes within its distance, however much there is of nothing around it.
    /// With a view by directions alone.
    float inverseDistance = 0;
    float nearest = kInfinity;  ///< distance of what is seen
    uint32_t looked = 0;        ///< nodes that were looked at
  };
  /// Radiance from where no surfel is, along unit directions away from the place; may be empty: none. Is
  /// called once at most.
  using Environment = std::function<void(std::span<const V3f> directions, std::span<Rgb> radiance)>;
  /// Irradiance at P on the side of N (unit; world space). `turn`, 0 to 1: the angle of the raster around N,
  /// for rasters of neighbours to differ. What is nearer than `nearest` is not seen.
  /// `lit` false: surfels are black, and only hide the environment.
  /// `outside`: the surface (Surfel::owner) on whose outer side the place is. Its inner sides are not to be
  /// seen from there; where they are, as its pieces do not fit, they look as the outer ones do.
  /// `view`: gets what is seen; the estimate's irradiance is then from there, so that it is the same when
  /// that is asked again. nullptr: nobody wants it.
  Estimate gather(const PointTree& tree, const V3f& P, const V3f& N, float turn, float nearest,
                  const Environment& environment, bool lit = true, uint32_t outside = Surfel::kNobody,
                  SurfelView* view = nullptr);

 private:
  struct Pixel {
    float weight;  ///< form factor: all sum up to 1
    V3f direction;
  };
  struct Item {
    float distance;
    float x, y, half;  ///< on its face, in pixels: where a square of its size is
    uint8_t face;
    bool isInner;   ///< of a closed surface: what is nearer is likely the same surface's outside
    uint32_t part;  ///< in parts_, when a view is wanted
    Rgb radiance;
  };
  /// A node, and where it is in the raster's frame, relative to the place.
  struct Visit {
    uint32_t node;
    float distance2;
    V3f local;
  };
  /// Nodes of which nothing is nearer than a distance, and items from there up to the next shell.
  struct Shell {
    std::vector<Visit> nodes;
    std::vector<Item> items;
  };
  static constexpr size_t kShells = 4 * 80;  ///< from 2^-40 on
  static size_t shellOf(float distance);
  float lookAround(const PointTree& tree);
  void push(const PointTree& tree, uint32_t node, size_t shell);
  static V3f abs(const V3f& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
  void look(const PointTree& tree, const Visit& visit, size_t shell);
  void findFull(size_t shell);
  bool isHidden(const Visit& visit, float radius) const;
  void add(const V3f& local, float area, const Rgb& radiance, bool isInner, SurfelView::Kind kind,
           uint32_t index);
  uint32_t addPart(SurfelView::Kind kind, uint32_t index);
  /// What rays through pixels may meet: the part of a plane that is in a rectangle, and in a disc or a box.
  /// World space, relative to the place.
  struct Target {
    V3f N, U, V, center;  ///< of the rectangle
    float halfU, halfV;
    float radius2;        ///< of a disc around the center; kInfinity: none
    V3f boxCenter, half;  ///< read with Shape::Boxed only
    /// Read with Shape::Triangle only: along U and V from the center, inside is where the sides' (x, y) times
    /// the place is z at most.
    std::array<V3f, 3> sides;
  };
  enum class Shape : uint8_t { Disc, Boxed, Triangle };
  void traceSurfel(const PointTree& tree, uint32_t index);
  void tracePlane(const PointTree& tree, uint32_t index, const PointTree::Node& node);
  bool isGap(Surfel::Inner inner, uint32_t owner, bool front) const;
  template <Shape kShape>
  void trace(const Target& target);
  /// The pixels of a face in which something of a target's rectangle may be.
  struct Pixels {
    int column0 = 0, column1 = 0, row0 = 0, row1 = 0;
  };
  struct LocalRectangle {
    V3f center, a, b;  ///< in the raster's frame: the middle, and from there to the middles of two sides
    V3f reach;         ///< half of its box's size
  };
  template <int kFace>
  static V3f onFace(const V3f& p);
  template <int kFace>
  Pixels pixelsOf(const LocalRectangle& rectangle) const;
  void draw(const Item& item);
  /// Pixels of a face stand in rows of stride_, the side faces' upper halves only.
  int rowsOf(int face) const { return face == 0 ? resolution_ : resolution_ / 2; }
  size_t firstOf(int face) const {
    const auto r = static_cast<size_t>(resolution_), s = static_cast<size_t>(stride_);
    return face == 0 ? 0 : r * s + static_cast<size_t>(face - 1) * s * (r / 2);
  }
  size_t at(int face, int row, int column) const {
    return firstOf(face) + static_cast<size_t>(row) * static_cast<size_t>(stride_) +
           static_cast<size_t>(column);
  }

  int resolution_, stride_;
  float maxSolidAngle_;
  std::vector<Pixel> pixels_;  ///< beyond the columns of a face: without weight
  struct Content {             ///< of what is drawn
    Rgb radiance{0, 0, 0};
    float covered = 0, inverse = 0;  ///< inverse: covered / distance
    float layer = 0;                 ///< distance of the first that is drawn
    float sum = 0;                   ///< of all that its layer would cover, more than one as well
    bool startsOutside = false;      ///< ... which is no closed surface's inside
  };
  bool isOwn(const Surfel& surfel, float distance2, float height) const;
  bool isBelow(const PointTree& tree, const PointTree::Node& node) const;
  bool isFull(size_t pixel) const;
  bool isBetweenFull(int face, int row, int column) const;
  float wholeOf(int face, int row, int column) const;
  struct Axes {
    V3f out, u, v;  ///< the way to the middle of a face, and those along it
  };
  std::array<Axes, 5> axes_;         ///< of faces, in the raster's frame
  std::vector<float> dx_, dy_, dz_;  ///< by pixel: world space
  std::vector<float> t_;             ///< of the nearest that the pixel's ray meets
  std::vector<int32_t> met_;         ///< where that one's radiance is
  struct Traced {
    Rgb radiance;  ///< at P, relative to the place
    V3f P;
    const std::array<V3f, 3>* slope;  ///< nullptr: none
    uint32_t part;                    ///< as Item's
  };
  std::vector<Traced> traced_;
  Rgb radianceMet(size_t pixel) const;
  /// When a view is wanted: what was drawn, and in which pixels.
  struct Drawn {
    uint32_t part, pixel;
    float share;
  };
  struct Part {
    SurfelView::Kind kind;
    uint32_t index;
    float weight;
    V3f along;
  };
  void write(SurfelView& view);
  bool isViewed_ = false;
  std::vector<Drawn> drawn_;
  std::vector<Part> parts_;
  std::vector<float> scale_;  ///< by pixels: of shares, to projected solid angles
  std::vector<Content> content_;
  std::vector<Shell> shells_;
  std::vector<uint64_t> full_;  ///< bits of pixels, by rows of all faces
  std::vector<V3f> openDirections_;
  std::vector<float> openWeights_;
  std::vector<Rgb> openRadiance_;
  V3f P_{0, 0, 0};
  Frame frame_{V3f(0, 0, 1)};
  float nearest_ = 0;
  uint32_t outside_ = Surfel::kNobody;
  uint32_t looked_ = 0;
};

}  // namespace patina
