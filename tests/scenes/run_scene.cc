// SPDX-License-Identifier: Apache-2.0
// Runs one case of a scene folder: renders by patina, then judges the picture by the rule in test.json.
//
//   run_scene PATINA FOLDER CASE WORK-FOLDER          exit status 0 = holds, 1 = does not, 77 = its data are
//   absent
//
// test.json: {"why": text, "cases": [case ...]}; a case has
//   name, why      the test's name; where its numbers come from
//   scene          RIB to render ["scene.rib"]; "shared:x" means x in the folder ../shared beside the source
//   tree args           arguments for patina, a list of texts, "folder:x" for x in the scene's folder; "-o
//   FILE" is added status, says   patina's exit status [0]; texts that must stand in its output rule
//   "constant"   every pixel equals "value" [r,g,b] within "pixel", and every 8x8 block within "block"
//                               (relative; either may be missing)
//                  "reference"  against "reference": mean of each channel within "mean" (relative), relMSE
//                  under "relmse" "same"       each list of "variants" is added to args in turn: the files
//                  agree bit for bit "renders"    all values are finite and the mean is within "range" [low,
//                  high] "says"       no picture is looked at
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "renderer/film/image.h"

namespace fs = std::filesystem;
using nlohmann::json;
using patina::ImageData;

namespace {

struct Absent : std::runtime_error {
  using runtime_error::runtime_error;
};
struct Failure : std::runtime_error {
  using runtime_error::runtime_error;
};

struct Run {
  fs::path patina, folder, work;
  json description;

  std::string name() const { return description.at("name"); }

  // A file of the folder, or of the data beside the project.
  fs::path data(const std::string& reference) const {
    constexpr std::string_view kShared = "shared:";
    const fs::path path = reference.starts_with(kShared) ? fs::path(PATINA_SOURCE_DIR).parent_path() /
                                                               "shared" / reference.substr(kShared.size())
                                                         : folder / reference;
    if (!fs::exists(path)) throw Absent("this case needs " + path.string() + ", which is absent");
    return path;
  }
};

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

int spawnAndWait(const std::vector<std::string>& command, const fs::path& log) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t child = 0;
  const int failed = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw Failure("cannot start " + command[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status)) throw Failure("patina was ended by signal " + std::to_string(WTERMSIG(status)));
  return WEXITSTATUS(status);
}

// Renders with additional arguments; returns the EXR's path.
fs::path render(const Run& run, const std::string& variant, const json& more = json::array()) {
  const json& d = run.description;
  const fs::path picture = run.work / (run.name() + variant + ".exr");
  const fs::path log = run.work / (run.name() + variant + ".log");
  std::vector<std::string> command = {run.patina, "-o", picture};
  for (const json& list : {d.value("args", json::array()), more})
    for (const std::string word : list)
      command.push_back(word.starts_with("folder:") ? (run.folder / word.substr(7)).string() : word);
  command.push_back(run.data(d.value("scene", "scene.rib")));
  fs::remove(picture);

  std::cout << "$";
  for (const std::string& word : command) std::cout << ' ' << word;
  std::cout << std::endl;
  const int status = spawnAndWait(command, log);
  const std::string output = contents(log);
  std::cout << output;
  if (status != d.value("status", 0)) throw Failure("patina ended with status " + std::to_string(status));
  for (const std::string text : d.value("says", json::array()))
    if (output.find(text) == std::string::npos) throw Failure("patina did not say: " + text);
  return picture;
}

ImageData load(const fs::path& path) {
  std::string error;
  auto image = patina::readImage(path, error);
  if (!image) throw Failure(error);
  if (image->channels < 3) throw Failure(path.string() + " has fewer than three channels");
  for (const float v : image->pixels)
    if (!std::isfinite(v)) throw Failure(path.string() + " holds a value that is not finite");
  return std::move(*image);
}

std::array<double, 3> mean(const ImageData& image, int x0, int y0, int x1, int y1) {
  std::array<double, 3> sum{};
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(image.pixel(x, y)[c]);
  for (double& s : sum) s /= static_cast<double>(x1 - x0) * (y1 - y0);
  return sum;
}

std::array<double, 3> mean(const ImageData& image) { return mean(image, 0, 0, image.width, image.height); }

void require(bool holds, const std::string& what) {
  if (!holds) throw Failure(what);
}

void judgeConstant(const json& d, const ImageData& image) {
  const std::array<double, 3> value = d.at("value");
  double worstPixel = 0, worstBlock = 0;
  const auto deviation = [&](const std::array<double, 3>& v) {
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c)
      worst = std::max(worst, std::abs(v[c] - value[c]) / std::abs(value[c]));
    return worst;
  };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      worstPixel = std::max(worstPixel, deviation(mean(image, x, y, x + 1, y + 1)));
  for (int y = 0; y + 8 <= image.height; y += 8)
    for (int x = 0; x + 8 <= image.width; x += 8)
      worstBlock = std::max(worstBlock, deviation(mean(image, x, y, x + 8, y + 8)));
  std::cout << "worst pixel " << worstPixel << ", worst 8x8 block " << worstBlock << " off\n";
  if (d.contains("pixel")) require(worstPixel <= d.at("pixel"), "a pixel is too far off");
  if (d.contains("block")) require(worstBlock <= d.at("block"), "a block is too far off");
}

void judgeReference(const Run& run, const ImageData& image) {
  const json& d = run.description;
  const ImageData reference = load(run.data(d.at("reference")));
  require(image.width == reference.width && image.height == reference.height, "the sizes differ");
  double relMse = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto v = static_cast<double>(image.pixel(x, y)[c]),
                   r = static_cast<double>(reference.pixel(x, y)[c]);
        relMse += (v - r) * (v - r) / (r * r + 0.01);
      }
  relMse /= 3.0 * image.width * image.height;
  const auto means = mean(image), expected = mean(reference);
  std::cout << "mean over reference";
  double worst = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    std::cout << ' ' << means[c] / expected[c];
    // A channel that is black in the reference must be black.
    worst = std::max(worst, expected[c] != 0 ? std::abs(means[c] / expected[c] - 1) : std::abs(means[c]));
  }
  std::cout << ", relMSE " << relMse << '\n';
  require(worst <= d.at("mean"), "the mean is too far off");
  require(relMse <= d.at("relmse"), "relMSE is too large");
}

void judgeRenders(const json& d, const ImageData& image) {
  const std::array<double, 2> range = d.at("range");
  const auto m = mean(image);
  std::cout << "mean " << m[0] << ' ' << m[1] << ' ' << m[2] << '\n';
  for (const double v : m) require(v >= range[0] && v <= range[1], "the mean is out of range");
}

void judge(const Run& run) {
  const json& d = run.description;
  const std::string rule = d.at("rule");
  if (rule == "same") {
    std::string first;
    for (const json& variant : d.at("variants")) {
      const std::string bytes =
          contents(render(run, "-" + std::to_string(&variant - &d.at("variants")[0]), variant));
      require(!bytes.empty(), "no picture was written");
      if (first.empty()) first = bytes;
      require(bytes == first, "the pictures differ");
    }
    return;
  }
  const fs::path picture = render(run, "");
  if (rule == "constant")
    judgeConstant(d, load(picture));
  else if (rule == "reference")
    judgeReference(run, load(picture));
  else if (rule == "renders")
    judgeRenders(d, load(picture));
  else
    require(rule == "says", "unknown rule " + rule);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: run_scene PATINA FOLDER CASE WORK-FOLDER\n";
    return 2;
  }
  try {
    Run run{fs::absolute(argv[1]), fs::absolute(argv[2]), fs::absolute(argv[4]), {}};
    fs::create_directories(run.work);
    fs::current_path(run.work);  // further Displays of a scene are written there
    const json test = json::parse(contents(run.folder / "test.json"));
    for (const json& description : test.at("cases"))
      if (description.at("name") == std::string(argv[3])) run.description = description;
    require(!run.description.is_null(), std::string("no such case: ") + argv[3]);
    judge(run);
    return 0;
  } catch (const Absent& e) {
    std::cout << "SKIPPED: " << e.what() << '\n';
    return 77;
  } catch (const std::exception& e) {
    std::cout << "FAILED: " << e.what() << '\n';
    return 1;
  }
}
