// SPDX-License-Identifier: Apache-2.0
// One shared object with shaders in it: opened, and refused with a reason when anything about it is wrong.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "patina/shader.h"

namespace patina {

/// An opened plugin whose descriptors have been checked: every pointer and string in them is there, every one
/// of the four entry points is set. Closes the shared object when destroyed.
class PluginFile {
 public:
  /// Opens the file and reads its table; none of its entry points is called. nullptr: `reason` says in one
  /// sentence what is wrong with it. The thread's floating-point state is what it was before. [any thread]
  static std::unique_ptr<PluginFile> open(const std::string& path, std::string& reason);

  ~PluginFile();
  PluginFile(const PluginFile&) = delete;
  PluginFile& operator=(const PluginFile&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<const PatinaShader*>& shaders() const { return shaders_; }
  const PatinaShader* find(std::string_view name) const;  ///< nullptr: not in this file

 private:
  PluginFile(std::string path, void* library) : path_(std::move(path)), library_(library) {}

  std::string path_;
  void* library_;
  std::vector<const PatinaShader*> shaders_;
};

/// What is wrong with a descriptor, in one sentence; empty = nothing. Runs no code of the plugin.
std::string findDescriptorFault(const PatinaShader& shader);

/// Parameter `index` of a checked shader, whatever the size of the struct that it was compiled with.
const PatinaParameter& parameterOf(const PatinaShader& shader, uint32_t index);

/// Numbers in one value of a parameter type (1, 3, 4 or 16); 0 = no such type.
uint32_t componentsOf(uint32_t type);

/// "float", "color" ...; "?" = no such type.
std::string_view typeName(uint32_t type);

}  // namespace patina
