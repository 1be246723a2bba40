// SPDX-License-Identifier: Apache-2.0
// A reader of picture files whose colours are linear Rec.709, whatever the file's are. Texels are converted
// as they come into the texture cache, before anything is filtered.
#pragma once

#include <OpenImageIO/imageio.h>

#include <string>

#include "renderer/shading/texture_color_module.h"

namespace patina::textures {

/// The name under which the cache knows `path` seen through `conversion`.
std::string convertedName(const std::string& path, const ColorConversion& conversion);

/// For ImageCache::add_file(): makes the reader. It is opened with a name of convertedName() and with
/// converterConfig(). Colour that is not associated with its alpha in the file is converted, then associated,
/// else unassociated for the conversion.
OIIO::ImageInput* makeConvertingInput();
OIIO::ImageSpec converterConfig(const ColorConversion& conversion);

/// Why a picture of this size is not read, "" = it may be: what a file claims is held against what it can
/// hold, before OpenImageIO takes memory for it. Untiled pictures, of which large parts are read at once,
/// have smaller bounds.
std::string sizeProblem(const std::string& path, const OIIO::ImageSpec& spec);

/// Why the end of a file's picture cannot be read; "" = it can. Of a TIFF that ends early OpenImageIO 2.4
/// gives what is missing as black and says that all went well, but when its last row or tile is asked for
/// alone.
std::string endProblem(OIIO::ImageInput& file);

}  // namespace patina::textures
