// SPDX-License-Identifier: Apache-2.0
// From linear values to those of a file: Exposure, the sRGB curve, Quantize with dither.
#pragma once

namespace patina {

// RI's Quantize: round(one * v + dither * random), clamped to [min, max]. one == 0 means floating point.
struct Quantizer {
  float one = 255, min = 0, max = 255, dither = 0.5f;
};

// RI's Exposure: (v * gain)^(1 / gamma); what is negative becomes 0 unless gamma is 1.
float exposed(float v, float gain, float gamma);

// Linear to sRGB (IEC 61966-2-1); clamped below at 0, not above.
float srgbEncoded(float linear);

// A whole number within [min, max]; NaN becomes min. `random` of RI's formula is a hash of pixel and channel
// in
// [-1, 1), so that the same picture is dithered the same way always. `quantizer.one` must not be 0.
float quantized(float v, const Quantizer& quantizer, int x, int y, int channel);

}  // namespace patina
