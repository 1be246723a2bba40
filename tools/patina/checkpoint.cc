// SPDX-License-Identifier: Apache-2.0
// The head of a checkpoint: written, read, compared.
#include "tools/patina/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "renderer/film/atomic_file.h"
#include "tools/patina/version.h"

namespace patina {
namespace {

constexpr std::array<char, 8> kMagic = {'P', 'a', 't', 'i', 'n', 'a', 'C', 'P'};
constexpr uint32_t kVersion = 2;
constexpr uint32_t kByteOrder = 0x01020304;

void put(ByteWriter& to, const PictureSettings& settings) {
  to.put(uint64_t{settings.size()});
  for (const auto& [name, value] : settings) to.putText(name), to.putText(value);
}

bool get(ByteReader& from, PictureSettings& settings) {
  uint64_t count = 0;
  if (!from.get(count) || count > from.remaining()) return false;
  for (uint64_t k = 0; k < count; ++k) {
    auto& [name, value] = settings.emplace_back();
    if (!from.getText(name) || !from.getText(value)) return false;
  }
  return true;
}

void put(ByteWriter& to, const std::vector<InputFile>& files) {
  to.put(uint64_t{files.size()});
  for (const InputFile& file : files)
    to.putText(file.path), to.put(file.kind), to.put(file.bytes), to.put(file.stamp);
}

bool get(ByteReader& from, std::vector<InputFile>& files) {
  uint64_t count = 0;
  if (!from.get(count) || count > from.remaining()) return false;
  for (uint64_t k = 0; k < count; ++k) {
    InputFile& file = files.emplace_back();
    if (!from.getText(file.path) || !from.get(file.kind) || !from.get(file.bytes) || !from.get(file.stamp) ||
        file.kind > InputFile::Kind::File)
      return false;
  }
  return true;
}

std::string oneLine(std::string text) {
  std::ranges::replace(text, '\n', ',');
  return text;
}

/// The first setting that differs, as "samples was 16, is 64"; "": none.
std::string difference(const PictureSettings& was, const PictureSettings& is) {
  const auto said = [](const std::string& value) { return value.empty() ? "not said" : value; };
  for (size_t k = 0; k < std::max(was.size(), is.size()); ++k) {
    if (k >= was.size()) return fmt::format("{} is {}", is[k].first, said(is[k].second));
    if (k >= is.size()) return fmt::format("{} was {}", was[k].first, said(was[k].second));
    if (was[k] != is[k])
      return fmt::format("{} was {}, {} is {}", was[k].first, said(was[k].second), is[k].first,
                         said(is[k].second));
  }
  return {};
}

}  // namespace

Checkpoint::Checkpoint(std::string write, std::string resume, ErrorHandler& errors)
    : write_(std::move(write)), resume_(std::move(resume)), errors_(errors) {
  if (isWritten() || !resume_.empty()) keepInputFiles(true);
}

bool Checkpoint::fail(const std::string& why) {
  errors_.report(Severity::Severe, RiError::BadFile, {},
                 fmt::format("checkpoint {} cannot be resumed: {}", resume_, why));
  return false;
}

bool Checkpoint::open() {
  if (isWritten())
    if (const std::string problem = AtomicFile::problem(write_); !problem.empty()) {
      errors_.report(Severity::Severe, RiError::System, {}, "checkpoint: " + problem);
      return false;
    }
  if (resume_.empty()) return true;
  reader_ = std::make_unique<ByteReader>();
  const std::string problem = reader_->open(resume_);
  return problem.empty() ? readHead() : fail(problem);
}

bool Checkpoint::readHead() {
  std::array<char, 8> magic{};
  uint32_t version = 0, order = 0;
  std::string build;
  ByteReader& from = *reader_;
  if (!from.get(magic) || magic != kMagic) return fail("it is no checkpoint");
  if (!from.get(order) || order != kByteOrder) return fail("it is of a machine with another order of bytes");
  if (!from.get(version) || version != kVersion)
    return fail(fmt::format("it is of version {}; this program reads version {}", version, kVersion));
  constexpr std::string_view kCut = "it ends too early";
  if (!from.getText(build)) return fail(std::string(kCut));
  if (build != versionText())
    return fail(
        fmt::format("another build of the program may make other bits: it was written by {}; this is {}",
                    oneLine(build), oneLine(versionText())));
  uint64_t finished = 0;
  if (!from.get(finished) || finished > from.remaining()) return fail(std::string(kCut));
  for (uint64_t k = 0; k < finished; ++k)
    if (!get(from, readFinished_.emplace_back())) return fail(std::string(kCut));
  uint8_t hasFilm = 0;
  if (!from.get(hasFilm)) return fail(std::string(kCut));
  readFilm_ = hasFilm != 0;
  if (readFilm_ && !(get(from, readSettings_) && get(from, readInputs_))) return fail(std::string(kCut));
  return true;
}

/// Whether the files that the picture was made from are what they were. Names may be others, as from another
/// folder. Which files had been read when a world began depends on the worlds before it: one that is finished
/// is not rendered again, so that its plugins and textures are not read; or it is, when its pictures have
/// gone.
bool Checkpoint::sameInputs() {
  const auto same = [](const InputFile& a) {
    return [&a](const InputFile& b) { return a.kind == b.kind && a.bytes == b.bytes && a.stamp == b.stamp; };
  };
  const std::vector<InputFile> now = inputFiles();
  for (const InputFile& is : now) {
    if (std::ranges::any_of(readInputs_, same(is)) ||
        std::ranges::find(ofRendering_, is) != ofRendering_.end())
      continue;
    const bool hasChanged = std::ranges::find(readInputs_, is.path, &InputFile::path) != readInputs_.end();
    return fail(fmt::format("it is of another scene{} {}{}", hasChanged ? ":" : ", without", is.path,
                            hasChanged ? " has changed" : ""));
  }
  for (const InputFile& then : readInputs_) {
    if (std::ranges::any_of(now, same(then))) continue;
    InputFile is;
    if (!describeInput(then.path, then.kind, is)) return fail(fmt::format("{} cannot be read", then.path));
    if (!same(is)(then)) return fail(fmt::format("{} has changed since", then.path));
  }
  return true;
}

Checkpoint::Found Checkpoint::beginWorld(const PictureSettings& settings) {
  settings_ = settings;
  inputsBefore_ = inputFiles().size();
  film_ = nullptr;
  if (!reader_) return Found::Nothing;
  const size_t world = finished_.size();
  const bool isFinished = world < readFinished_.size();
  if (!isFinished && (world > readFinished_.size() || !readFilm_)) return Found::Nothing;
  const std::string other = difference(isFinished ? readFinished_[world] : readSettings_, settings);
  if (!other.empty()) {
    fail("it is of another picture: " + other);
    return Found::Other;
  }
  if (isFinished) return Found::Finished;
  if (!sameInputs()) return Found::Other;
  film_ = reader_.get();
  return Found::Begun;
}

void Checkpoint::write(const SaveFilm& saveFilm) { writeFile(saveFilm); }

void Checkpoint::finishWorld() {
  finished_.push_back(settings_);
  film_ = nullptr;
  const std::vector<InputFile> files = inputFiles();
  ofRendering_.insert(ofRendering_.end(), files.begin() + static_cast<ptrdiff_t>(inputsBefore_), files.end());
  // While worlds of before are gone through, what follows them in the file is still needed.
  const bool isBehind = reader_ && finished_.size() < readFinished_.size() + (readFilm_ ? 1 : 0);
  if (isWritten() && !isBehind) writeFile({});
}

void Checkpoint::remove() {
  if (isWritten()) std::remove(write_.c_str());
}

void Checkpoint::writeFile(const SaveFilm& saveFilm) {
  AtomicFile file(write_);
  ByteWriter to([&](const std::string& bytes) { return file.write(bytes); });
  to.put(kMagic), to.put(kByteOrder), to.put(kVersion);
  to.putText(versionText());
  to.put(uint64_t{finished_.size()});
  for (const PictureSettings& settings : finished_) put(to, settings);
  to.put(uint8_t{saveFilm ? uint8_t{1} : uint8_t{0}});
  if (saveFilm) {
    put(to, settings_);
    put(to, inputFiles());
    saveFilm(to);
  }
  std::string problem = to.finish();
  if (problem.empty()) problem = file.commit();
  if (!problem.empty())
    errors_.reportOnce(Severity::Error, RiError::System, {}, "checkpoint", "checkpoint: " + problem);
}

}  // namespace patina
