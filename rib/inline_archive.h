// SPDX-License-Identifier: Apache-2.0
// The recorded text of an ArchiveBegin ... ArchiveEnd block, to be replayed by RibParser::parseArchive.
#pragma once

#include <memory>
#include <string>

#include "rib/error.h"

namespace patina {

struct EncodingTables;  // the requests and strings that binary RIB had defined before the block

// A value: copies share the text.
struct InlineArchive {
  std::shared_ptr<const std::string> text;
  std::shared_ptr<const EncodingTables> tables;  // null for plain ASCII
  Location start;                                // of the text's first byte
};

}  // namespace patina
