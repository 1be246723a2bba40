// SPDX-License-Identifier: Apache-2.0
// Texture files made of pictures, inside of the module: see PatinaTextureModule.
#pragma once

#include "renderer/shading/texture_module.h"

namespace patina::textures {

int isPicture(const char* path);
int make(const PatinaTextureToMake* what, char* error, size_t errorSize);

}  // namespace patina::textures
