// SPDX-License-Identifier: Apache-2.0
// --checkpoint and --resume: the file that a render can go on from, and whether it is of the same picture.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/film/byte_stream.h"
#include "rib/error.h"
#include "rib/input_files.h"

namespace patina {

/// What a picture depends on beside the files it is made from: names and values, in a fixed order.
using PictureSettings = std::vector<std::pair<std::string, std::string>>;

/// One file for a whole run: the worlds that are finished, and the buckets of the one under way. It is
/// written beside its place, synchronised and renamed, so that there is always a whole one; numbers are in
/// the machine's own order of bytes. [main]
class Checkpoint {
 public:
  /// Nothing is written if `write` is "", nothing read if `resume` is.
  Checkpoint(std::string write, std::string resume, ErrorHandler& errors);

  bool isWritten() const { return !write_.empty(); }
  const std::string& path() const { return write_; }

  /// Reads the head of the file to resume. False: it cannot be gone on from, which has been reported.
  bool open();

  enum class Found { Nothing, Finished, Begun, Other };
  /// What the file holds of the next world. Other: not what these settings and the files that have been read
  /// make, which has been reported.
  Found beginWorld(const PictureSettings& settings);
  /// Where the film is, when a world was found Begun; else nullptr.
  ByteReader* film() { return film_; }

  /// Writes the file anew: the world under way with its film.
  void write(const std::function<void(ByteWriter&)>& saveFilm);
  /// The pictures of the world under way are in their files.
  void finishWorld();
  /// All is done: the file is of no more use.
  void remove();

 private:
  using SaveFilm = std::function<void(ByteWriter&)>;
  bool readHead();
  bool fail(const std::string& why);
  bool sameInputs();
  void writeFile(const SaveFilm& saveFilm);

  std::string write_, resume_;
  ErrorHandler& errors_;
  std::unique_ptr<ByteReader> reader_;
  ByteReader* film_ = nullptr;
  // Of the file that is resumed.
  std::vector<PictureSettings> readFinished_;
  bool readFilm_ = false;  // a world was under way
  PictureSettings readSettings_;
  std::vector<InputFile> readInputs_;
  // Of this run.
  std::vector<PictureSettings> finished_;
  PictureSettings settings_;
  size_t inputsBefore_ = 0;             // files that were known when the world began
  std::vector<InputFile> ofRendering_;  // those that were first read when worlds of before were rendered
};

}  // namespace patina
