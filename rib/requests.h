// SPDX-License-Identifier: Apache-2.0
// The table of all requests that the parser knows, with their arguments.
#pragma once

#include <span>
#include <string_view>

namespace patina {

class Arguments;

struct RibRequest {
  std::string_view name;
  std::string_view usage;    // its arguments in order; "..." stands for a parameter list; empty = none
  void (*call)(Arguments&);  // checks the arguments and calls the handler
};

std::span<const RibRequest> ribRequests();
const RibRequest* findRibRequest(std::string_view name);    // null: unknown
std::string_view nearestRibRequest(std::string_view name);  // empty: none is near

}  // namespace patina
