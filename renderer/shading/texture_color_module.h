// SPDX-License-Identifier: Apache-2.0
// Colour spaces of texture files, inside of the module that reads them: which one a file is in, and the way
// from there to linear Rec.709.
#pragma once

#include <OpenColorIO/OpenColorIO.h>
#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <functional>
#include <string>

namespace patina::textures {

/// Lives as long as the process. [any thread]
struct ColorConversion {
  std::string name;
  /// `pixels` interleaved triples, in place.
  std::function<void(float* rgb, size_t pixels)> apply;
};

/// The way to linear Rec.709 from the colour space of a file; nullptr: its values are linear already. In this
/// order decide
///   1. the name: its last word, suffixes and tile numbers apart, is "raw", "data", "linear", "lin" or
///   "srgb"; words are parted by '_', '-' and '.';
///   2. the file rules of `config`, but for its rule for all the rest;
///   3. the file's tag (oiio:ColorSpace): sRGB, Rec709 (which OpenImageIO says of all portable pixmaps; sRGB
///      is meant), a gamma, linear, or a colour space of `config`;
///   4. the type: eight bits are sRGB, all else is linear.
/// The sRGB curve is that of IEC 61966-2-1. `config` may be null. From its colour spaces the way leads by the
/// role aces_interchange; a config without that is expected to have linear Rec.709 as scene_linear. Throws
/// OCIO::Exception. [any thread]
const ColorConversion* conversionOf(const std::string& path, const OIIO::ImageSpec& spec,
                                    const OCIO_NAMESPACE::ConstConfigRcPtr& config);

/// The sRGB curve.
const ColorConversion* srgb();

/// The word of rule 1: "" = the name says nothing.
std::string colorWord(const std::string& path);

}  // namespace patina::textures
