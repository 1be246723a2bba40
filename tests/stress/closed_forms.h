// SPDX-License-Identifier: Apache-2.0
// Scenes whose pictures are known by a formula.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/stress/pictures.h"

namespace patina::stress {

/// What a mode claims of a case.
struct Claim {
  const char* mode;
  /// How far the mean over many pictures may be off, relative to the mean of the expected picture, in the
  /// worst block; noise comes on top, as it is measured.
  double bias;
  const char* reason;  ///< of the bias
  /// The renderer is known to be further off than that, and why: the table says so, and whether it still is.
  /// nullptr: the claim holds.
  const char* known = nullptr;
  bool slow = false;  ///< left out where the suite is short
};

struct ClosedForm {
  std::string group, name;
  std::string formula;  ///< what `expected` is, in a few words
  std::string rib;
  Adjust adjust;                 ///< may be empty
  int width = 8, height = 8;     ///< of the picture
  int block = 4;                 ///< pixels along the blocks that are judged
  std::vector<double> expected;  ///< radiance, one value per pixel
  std::vector<Claim> claims;
  int samples = 4;        ///< camera samples per pixel where the suite is short
  int lightSamples = 64;  ///< shadow rays per point there, in other modes than path
  /// In the study of convergence: one of each kind is enough.
  bool converges = false;
};

// Each adds its cases.
void addFurnaces(std::vector<ClosedForm>& cases);
void addFormFactors(std::vector<ClosedForm>& cases);
void addLights(std::vector<ClosedForm>& cases);
void addSignals(std::vector<ClosedForm>& cases);

// ---- What cases are made of -------------------------------------------------------------------------------

/// "Format", a box filter of one pixel, and no more.
std::string format(int width, int height);

/// An orthographic camera `above` the plane y = 0 that looks straight down at (x, z): what is higher is
/// behind it. Its window is 2 half wide; up in the picture is z.
std::string lookDown(double x, double above, double z, double half, double halfHeight);

/// One value for each pixel of such a window: the mean of f(x, z) over grid x grid points of the pixel.
std::vector<double> overWindow(const std::function<double(double, double)>& f, int width, int height,
                               double x, double z, double half, double halfHeight, int grid = 4);

/// A Polygon request.
std::string polygon(const std::vector<V3d>& corners);

/// Irradiance at P from a polygon of radiance 1, above the horizon of N (Lambert 1760; Arvo, "Applications of
/// irradiance tensors", SIGGRAPH 1995, eq. 2). The corners are in one plane, P is not; either sense of
/// rotation.
double polygonIrradiance(const V3d& P, const V3d& N, std::vector<V3d> corners);

}  // namespace patina::stress
