// SPDX-License-Identifier: Apache-2.0
// What becomes of each request: the table of the documentation, made from the code.
#pragma once

#include <string>
#include <string_view>

namespace patina {

enum class Support : uint8_t {
  CarriedOut,  ///< as RI has it
  Mapped,      ///< to the nearest thing that there is
  Ignored      ///< named in one warning with the number of its uses
};

struct RequestSupport {
  Support support = Support::CarriedOut;
  std::string_view note;  ///< what is not as RI has it
};

/// Of a request that the parser knows. A request that SceneBuilder leaves to unhandled() is Ignored, and a
/// test sees to it that the two agree.
RequestSupport supportOf(std::string_view request);

/// The table as Markdown, in the order of ribRequests().
std::string requestTable();

}  // namespace patina
