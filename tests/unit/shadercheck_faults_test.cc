// SPDX-License-Identifier: Apache-2.0
// Each plugin that does one thing wrong is caught, with a message that names it; those that do nothing wrong
// pass.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>

#include "renderer/shadercheck/check_shader.h"
#include "renderer/shading/plugin_loader.h"

namespace patina::shadercheck {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> faultsOf(const std::string& name, const CheckOptions& options = {}) {
  PluginLoader loader({{}, PATINA_BINARY_DIR "/tests/plugins", false});
  const PluginLoader::Result& found = loader.find(name);
  EXPECT_NE(found.shader, nullptr) << found.error;
  if (!found.shader) return {};
  const Verdict verdict = checkShader(*found.shader, options);
  EXPECT_EQ(verdict.shader, name);
  EXPECT_EQ(verdict.checks, 18);
  std::vector<std::string> texts;
  for (const Fault& fault : verdict.faults) texts.push_back(toString(verdict.shader, fault));
  return texts;
}

struct Case {
  const char *plugin, *message;
  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.plugin; }
};

class WrongShader : public testing::TestWithParam<Case> {};

TEST_P(WrongShader, IsCaughtAndNamed) {
  EXPECT_THAT(faultsOf(GetParam().plugin),
              Contains(HasSubstr(std::string(GetParam().plugin) + ": " + GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(
    ShaderCheck, WrongShader,
    testing::Values(
        Case{"wrong_reads_i",
             "radiosity reads I, which it does not declare (defaults; lane 0: reflectance.x is"},
        Case{"wrong_needs_i",
             "radiosity crashed: signal 11, Segmentation fault (I, which it does not declare, is "
             "NULL; defaults) [undeclared channels]"},
        Case{"wrong_reads_neighbours",
             "radiosity gives a lane other results in a batch of one (defaults; lane"},
        Case{"wrong_out_of_bounds",
             "radiosity wrote behind the end of reflectance.x (defaults; a batch of 37: index 48 of a plane "
             "of 48)"},
        Case{"wrong_writes_input", "radiosity wrote into its input Cs"},
        Case{"wrong_gives_nan",
             "radiosity gives a value that is not finite: reflectance.x (defaults; hostile lane"},
        Case{"wrong_makes_energy",
             "radiosity makes energy: reflectance + transmittance is more than 1 (defaults; "},
        Case{"wrong_exceeds_bound",
             "displacement moves P further than its displacement_bound (defaults; lane 0: by"},
        Case{"wrong_false_no_op",
             "radiosity gives emission.x, though its traits say that it does nothing (defaults;"},
        Case{"wrong_false_black", "radiosity reflects, though its traits say BLACK (defaults; lane"},
        Case{"wrong_remembers", "radiosity depends on earlier calls (defaults; lane 0"},
        Case{"wrong_races", "radiosity gives other results when several threads call it at once: a race ("},
        Case{"wrong_ignores_stride",
             "radiosity has other results when channels are planes of stride 0 (defaults;"},
        Case{"wrong_wrong_pdf",
             "light (evaluate) has a wrong pdf: it does not integrate to 1 over the sphere "
             "(defaults; the integral is 2.0"},
        Case{"wrong_wrong_samples",
             "light (sample) has a wrong pdf: directions are not drawn by it (defaults; "},
        Case{"wrong_no_fall_off",
             "light (sample) does not fall off with the square of the distance, as FROM_POINT "
             "says (defaults; "},
        Case{"wrong_long_directions",
             "light (sample) gives directions that are not of unit length (defaults; lane"},
        Case{"wrong_bright_lobe",
             "view lobe 0: the weight is outside of [0, 1] (defaults; lane 0: 2) [lobes]"},
        Case{"wrong_lobe_pdf",
             "view lobe \"cosine\" has a wrong pdf: it does not integrate to the share of samples that are "
             "directions (defaults; lane"},
        Case{"wrong_lobe_samples",
             "view lobe \"cosine\" has a wrong pdf: directions are not drawn by it (defaults; lane"},
        Case{"lobe_makes_energy",
             "view lobe \"cosine\" makes energy: its f integrates to more than 1 (defaults; lane"},
        Case{"one_way_lobe",
             "view lobe \"cosine\" is not reciprocal, and does not say NOT_RECIPROCAL (defaults; lane"},
        Case{"nan_lobe", "view lobe \"cosine\" gives a value that is not finite (defaults; lane"},
        Case{"negative_lobe", "view lobe \"cosine\" gives a negative value (defaults; lane"},
        Case{"long_lobe_samples",
             "view lobe \"cosine\" gives directions that are not of unit length (defaults; lane"},
        Case{"unknown_lobe", "view lobe 0: there is no such type of lobes (defaults; lane 0: 1025) [lobes]"},
        Case{"nameless_lobe", "prepare registered a lobe that has no name or no documentation (defaults) ["},
        Case{"wrong_long_normals",
             "displacement writes normals that are not of unit length (defaults; lane 0: the length is "},
        Case{"wrong_late_texture", "radiosity called open_texture() outside of prepare (defaults) ["},
        Case{"wrong_bright_air",
             "atmosphere gives a transmittance outside of [0, 1] (defaults; segment 0 of"},
        Case{"wrong_undeclared_rays", "radiosity traced rays where it has declared none (defaults) ["},
        Case{"wrong_too_many_rays",
             "radiosity traced more rays for a point than the 2 that it has declared (defaults) ["},
        Case{"wrong_nan_rays", "radiosity traced a ray that is not finite or has no direction (defaults) ["},
        Case{"wrong_rays_of_displacement",
             "prepare declared rays of an entry point that may trace none (defaults) ["},
        Case{"wrong_default_out_of_range",
             "parameter table has the default 0.5 for \"Kd\", outside of its range [0, "
             "0.25] [parameter table]"},
        Case{"wrong_exits",
             "radiosity ended the process, with exit status 3 (hostile inputs; defaults) [finite]"}),
    [](const auto& tested) { return std::string(tested.param.plugin); });

TEST(ShaderCheck, FindsNothingWhereNothingIsWrong) {
  EXPECT_THAT(faultsOf("wrong_nothing"), IsEmpty());
  EXPECT_THAT(faultsOf("wrong_right_pdf"), IsEmpty());
  EXPECT_THAT(faultsOf("right_lobe"), IsEmpty());
  EXPECT_THAT(faultsOf("wrong_right_rays"), IsEmpty());
}

TEST(ShaderCheck, StopsAShaderThatDoesNotReturn) {
  EXPECT_THAT(faultsOf("wrong_hangs", {.cpuSeconds = 2, .wallSeconds = 300}),
              Contains(HasSubstr(
                  "radiosity did not return within 2 s of CPU time (hostile inputs; defaults) [finite]")));
}

// A shader that waits takes no CPU time: the clock on the wall stops it. One second is far more than the
// checks of this plugin take by themselves.
TEST(ShaderCheck, StopsAShaderThatWaits) {
  EXPECT_THAT(faultsOf("wrong_waits", {.cpuSeconds = 300, .wallSeconds = 2}),
              Contains(HasSubstr("radiosity did not return within 2 s (hostile inputs; defaults) [finite]")));
}

// Allocators of sanitizers do not say how much they hold.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ShaderCheck, NoticesWhatIsNotReleased) {
  EXPECT_THAT(faultsOf("wrong_leaks"), Contains(AllOf(HasSubstr("wrong_leaks: release leaves 4"),
                                                      HasSubstr("bytes behind of every prepare"))));
}
#endif

}  // namespace
}  // namespace patina::shadercheck
