// SPDX-License-Identifier: Apache-2.0
// Captions of contact sheets: letters of 5 x 7 pixels.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace patina::bench {

inline constexpr int kLetterWidth = 6, kLetterHeight = 9;  ///< with the space to the next one

/// Writes light text into a picture of RGB bytes, its upper left corner at (x, y); what is beyond `right` or
/// the picture is left out. Capitals but M, S and E are written small, what has no letter as a box.
void drawText(std::span<uint8_t> rgb, int width, int x, int y, int right, std::string_view text);

}  // namespace patina::bench
