// tinygltf's types.  model.cpp compiles the library, without its file access and its pictures: the
// loader reads all bytes through the AssetReader.
#pragma once

#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include "server/gltf/view.h"

namespace lucerna::gltf {

/// The accessors, buffer views, meshes, nodes, scenes, cameras, skins and animations of a file.
/// `root` has passed check_structure.  Other members, extensions and extras are left out.
tinygltf::Model parse_model(const View& root);

}  // namespace lucerna::gltf
