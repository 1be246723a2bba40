// SPDX-License-Identifier: Apache-2.0
// The table of requests says what the scene builder does.
#include "renderer/scene/request_support.h"

#include <fstream>
#include <set>
#include <sstream>

#include "every_request.h"
#include "rib/requests.h"
#include "scene_fixture.h"

namespace patina {
namespace {

/// Requests whose warning says that they are not carried out.
std::set<std::string, std::less<>> ignoredIn(const Built& built) {
  std::set<std::string, std::less<>> ignored;
  for (const std::string& message : built.messages) {
    const size_t begin = message.find("request "), end = message.find(" is not carried out yet");
    if (begin == std::string::npos || end == std::string::npos) continue;
    const std::string request = message.substr(begin + 8, end - begin - 8);
    if (request.find(' ') == std::string::npos) ignored.insert(request);  // not only some kind of it
  }
  return ignored;
}

TEST(RequestSupport, IgnoredAreThoseThatTheBuilderDoesNotKnow) {
  const auto ignored = ignoredIn(build(test::kEveryRequest));
  for (const RibRequest& request : ribRequests())
    EXPECT_EQ(supportOf(request.name).support == Support::Ignored, ignored.contains(request.name))
        << request.name;
}

TEST(RequestSupport, TheDocumentIsTheTable) {
  std::ifstream file(PATINA_SOURCE_DIR "/renderer/scene/requests.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find(requestTable()), std::string::npos)
      << "renderer/scene/requests.md is not up to date: write the output of patina --requests to its end";
}

}  // namespace
}  // namespace patina
