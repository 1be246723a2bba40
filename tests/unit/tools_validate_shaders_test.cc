// SPDX-License-Identifier: Apache-2.0
// --validate-shaders: shaders that do wrong are named in a render, good ones are not, and the picture stays
// the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace patina {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string contents(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class ValidateShaders : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "patina-validate-XXXXXX";
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  struct Run {
    int status;
    std::string output, picture;
  };
  Run render(const std::string& requests, const std::string& arguments) {
    std::ofstream(folder_ / "scene.rib")
        << "Format 24 18 1 Projection \"perspective\" \"fov\" [40] Translate 0 0 4\n"
           "WorldBegin LightSource \"distantlight\" 1\n"
        << requests << "\nSphere 1 -1 1 360 \"Cs\" [1 0.5 0.2  0.3 1 0.6  0.2 0.4 1  1 1 0.1]\nWorldEnd\n";
    const std::string command = "cd " + folder_.string() +
                                " && " PATINA_BINARY_DIR "/bin/patina --shader-path " PATINA_BINARY_DIR
                                "/tests/plugins -o p.exr --rays 8 " +
                                arguments + " scene.rib >out.txt 2>&1";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(folder_ / "out.txt"),
            contents(folder_ / "p.exr")};
  }

  fs::path folder_;
};

struct Wrong {
  const char *request, *says;
};

TEST_F(ValidateShaders, NamesWhatIsWrongOnlyWhenAsked) {
  for (const auto& [request, says] :
       {Wrong{"Surface \"wrong_makes_energy\"",
              "radiosity makes energy: reflectance + transmittance is more than 1"},
        Wrong{"Surface \"wrong_reads_neighbours\"",
              "radiosity gives a point other values alone than in a batch"},
        Wrong{"Surface \"wrong_reads_i\"", "radiosity reads I, which its traits do not declare"},
        Wrong{"Surface \"wrong_false_black\"", "reflects or transmits, though its traits say BLACK"},
        Wrong{"Surface \"wrong_bright_lobe\"", "outside of [0, 1]"},
        Wrong{"Displacement \"wrong_exceeds_bound\"", "further than its displacement_bound"}}) {
    const Run checked = render(request, "--validate-shaders");
    EXPECT_EQ(checked.status, 1) << request;
    EXPECT_THAT(checked.output, HasSubstr(says));
    EXPECT_THAT(checked.output, HasSubstr("scene.rib:3:")) << "the request of the shader";
    EXPECT_THAT(checked.output, HasSubstr("of the primitive at scene.rib:4:")) << "the place of the point";
    const Run plain = render(request, "");
    EXPECT_EQ(plain.status, 0) << plain.output;
  }
}

// Whether they are validated or not.
TEST_F(ValidateShaders, RaysBeyondWhatIsDeclaredAreRefused) {
  for (const auto& [request, says] :
       {Wrong{"Surface \"wrong_too_many_rays\"",
              "radiosity asks for more rays per point than it has declared"},
        Wrong{"Surface \"wrong_undeclared_rays\"", "it traces rays where it has declared none"},
        Wrong{"Surface \"wrong_rays_of_displacement\"",
              "it declares 2 rays per point for an entry point that may trace none"}}) {
    const Run plain = render(request, "");
    EXPECT_EQ(plain.status, 1) << request;
    EXPECT_THAT(plain.output, HasSubstr(says));
    EXPECT_THAT(plain.output, HasSubstr("scene.rib:3:")) << "the request of the shader";
  }
  const Run strange = render("Surface \"wrong_nan_rays\"", "");
  EXPECT_EQ(strange.status, 0) << strange.output;
  EXPECT_THAT(strange.output, HasSubstr("asks for rays that are not finite or have no direction"));
  const Run right = render("Surface \"wrong_right_rays\"", "--validate-shaders");
  EXPECT_EQ(right.status, 0) << right.output;
}

TEST_F(ValidateShaders, GoodShadersPassAndThePictureIsTheSame) {
  for (const char* request :
       {"Surface \"wrong_nothing\" Displacement \"wrong_nothing\"",
        "Surface \"dots\" Displacement \"noisebump\"", "Surface \"dielectric\"", "Surface \"marble\"",
        "Surface \"leaf\"", "Surface \"matte\" \"emission\" [1 1 1]"}) {
    const Run checked = render(request, "--validate-shaders"), plain = render(request, "");
    EXPECT_EQ(checked.status, 0) << request << checked.output;
    EXPECT_FALSE(plain.picture.empty());
    EXPECT_TRUE(checked.picture == plain.picture) << request;
  }
}

const std::string lit = "Surface \"matte\" ";

TEST_F(ValidateShaders, NamesWhatIsWrongWithLights) {
  for (const auto& [request, says] :
       {Wrong{"LightSource \"wrong_wrong_pdf\" 2",
              "light has a wrong pdf: 0.2502 of its samples fall where they should be 0.5"},
        Wrong{"LightSource \"wrong_wrong_samples\" 2", "light has a wrong pdf: 0.2"},
        Wrong{"LightSource \"wrong_no_fall_off\" 2",
              "light does not fall off with the square of the distance"},
        Wrong{"LightSource \"wrong_long_directions\" 2",
              "light (sample) gives directions that are not of unit length"},
        Wrong{"LightSource \"wrong_negative_light\" 2",
              "light (sample) gives a negative radiance: (1, 1, -0.5)"},
        Wrong{"LightSource \"wrong_evaluates_otherwise\" 2",
              "light (evaluate) gives another radiance or pdf than sample for its directions: radiance (1, "
              "0.9, "
              "1) and (1, 1, 1)"},
        Wrong{"LightSource \"wrong_light_reads_neighbours\" 2",
              "gives a point other values alone than in a batch"},
        Wrong{"LightSource \"wrong_random_delta\" 2",
              "light depends on random numbers, though it is a DELTA"}}) {
    const Run checked = render(lit + request, "--validate-shaders");
    EXPECT_EQ(checked.status, 1) << request;
    EXPECT_THAT(checked.output, HasSubstr(says)) << request;
    EXPECT_THAT(checked.output, HasSubstr("scene.rib:3:")) << "the request of the shader";
    const Run plain = render(lit + request, "");
    EXPECT_EQ(plain.status, 0) << plain.output;
  }
}

TEST_F(ValidateShaders, GoodLightsPassAndThePictureIsTheSame) {
  for (const char* request :
       {"LightSource \"wrong_right_pdf\" 2", "LightSource \"sunsky\" 2 \"turbidity\" [4]",
        "LightSource \"distantlight\" 2 \"angle\" [0.53]", "LightSource \"ambientlight\" 2",
        "LightSource \"spotlight\" 2 \"from\" [3 3 -3] \"to\" [0 0 0] \"beamdistribution\" [60]",
        "LightSource \"pointlight\" 2 \"from\" [3 3 -3] \"rampend\" [5]",
        "AttributeBegin AreaLightSource \"arealight\" 2 \"focus\" [3] Translate 0 3 0 Sphere 0.5 -0.5 0.5 "
        "360 "
        "AttributeEnd Illuminate 2 1"}) {
    const Run checked = render(lit + request, "--validate-shaders"), plain = render(lit + request, "");
    EXPECT_EQ(checked.status, 0) << request << checked.output;
    EXPECT_FALSE(plain.picture.empty());
    EXPECT_TRUE(checked.picture == plain.picture) << request;
  }
}

}  // namespace
}  // namespace patina
