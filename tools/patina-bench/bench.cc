// SPDX-License-Identifier: Apache-2.0
// Testing agreement, comparing files of results.
#include "tools/patina-bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>

#include "tools/patina-bench/compare.h"
#include "tools/patina-bench/session.h"

namespace patina::bench {
namespace {

// Seeds of the second setting of a test of agreement: the first has 1, 2 ...
constexpr int kSecondSeeds = 500'000;

}  // namespace

int testAgreement(const BenchOptions& options, const std::string& first, const std::string& second, int seeds,
                  int block) {
  const Session session(options);
  std::vector<Setting> sides;
  for (const std::string& text : {first, second}) {
    std::istringstream in(text);
    Setting side{"", sides.empty() ? "agree1" : "agree2", {}};
    in >> side.mode;
    for (std::string word; in >> word;) side.args.push_back(word);
    if (side.mode.empty() || side.mode.starts_with('-'))
      throw std::runtime_error("expected MODE and its arguments, not \"" + text + "\"");
    sides.push_back(std::move(side));
  }
  std::vector<Agreement> agreements;
  for (const Scene& scene : session.load(options.scenes)) {
    if (!options.only.empty() && !isWanted(options.only, scene.name, sides)) continue;
    std::array<std::vector<std::vector<double>>, 2> means;
    Agreement agreement;
    // By turns, and the pictures of a side are of equal cost.
    for (int k = 0; k < seeds && agreement.failure.empty(); ++k)
      for (size_t side = 0; side < 2 && agreement.failure.empty(); ++side) {
        Run run = plan(session, scene, sides[side], session.builds[0], 0);
        run.seed = static_cast<int>(side) * kSecondSeeds + k + 1;
        const ImageData picture = render(session.builds[0], scene, session.render, run);
        agreement.failure = run.failure;
        if (run.failure.empty()) means[side].push_back(blockMeans(picture, block));
      }
    if (agreement.failure.empty()) agreement = compareBlocks(means[0], means[1]);
    agreement.scene = scene.name;
    agreements.push_back(agreement);
    say(fmt::format("{}: {}\n", scene.name, agreement.failure.empty() ? "done" : agreement.failure));
  }
  const std::string text = fmt::format(
      "# {} against {}\n\nMeans of blocks of {} x {} pixels over {} pictures each; Welch's t-test, "
      "significance {} over all blocks and channels of a scene.\n\n{}",
      first, second, block, block, seeds, kSignificance, describeAgreements(agreements));
  writeText(session.folder / "agreement.md", text);
  say("\n" + text);
  const auto bad = [](const Agreement& a) { return a.differing > 0 || !a.failure.empty(); };
  return std::ranges::any_of(agreements, bad) ? 1 : 0;
}

int compareFiles(const std::string& before, const std::string& after) {
  const Results old = readResults(before), now = readResults(after);
  const std::vector<Point> a = summarizeRuns(old), b = summarizeRuns(now);
  for (const auto& [points, file] : {std::pair(&a, before), std::pair(&b, after)})
    if (namesOf(*points, &Point::build).size() > 1)
      throw std::runtime_error(file + " holds results of several programs");
  const std::vector<Change> changes = compareRuns(a, b);
  say(describeChanges(changes));
  return changes.empty() || std::ranges::any_of(changes, [](const Change& c) { return c.changed; }) ? 1 : 0;
}

}  // namespace patina::bench
