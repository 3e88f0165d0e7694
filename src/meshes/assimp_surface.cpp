#include "meshes/assimp_surface.hpp"

#include <algorithm>
#include <cmath>

#include "meshes/corners.hpp"
#include "meshes/mesh_file.hpp"

#ifdef UNIBODY_HAS_ASSIMP
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace unibody {

bool is_for_assimp(const std::string& path) {
  std::string name = path;
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(".gltf") || name.ends_with(".glb") || name.ends_with(".dae");
}

#ifdef UNIBODY_HAS_ASSIMP

namespace {

class Surface {
 public:
  Surface(const std::string& path, const aiScene& scene, bool soup) : path_(path), scene_(scene), corners_(soup) {}

  TriangleMesh read() {
    add(*scene_.mRootNode, aiMatrix4x4());
    if (corners_.mesh.triangles.empty()) fail_at(path_, 0, "no triangles", "a surface");
    return std::move(corners_.mesh);
  }

 private:
  void add(const aiNode& node, const aiMatrix4x4& above) {
    const aiMatrix4x4 place = above * node.mTransformation;
    for (unsigned k = 0; k < node.mNumMeshes; ++k) add(*scene_.mMeshes[node.mMeshes[k]], place);
    for (unsigned k = 0; k < node.mNumChildren; ++k) add(*node.mChildren[k], place);
  }
  void add(const aiMesh& mesh, const aiMatrix4x4& place) {
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;  // points and lines
      ++count_;
      const std::string where = " in face " + std::to_string(count_);
      std::vector<Vec3> corners;
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        if (face.mIndices[k] >= mesh.mNumVertices) fail_at(path_, 0, "a node that isn't there" + where, "one of the file's");
        const aiVector3D x = place * mesh.mVertices[face.mIndices[k]];
        corners.emplace_back(x.x, x.y, x.z);
        if (!corners.back().allFinite()) fail_at(path_, 0, "no finite place" + where, "finite numbers (m)");
      }
      if (corners.size() > 3 && !is_convex(corners))
        fail_at(path_, 0, "a face that isn't convex" + where, "triangles or convex faces");
      for (std::size_t k = 2; k < corners.size(); ++k)
        if (!corners_.add({corners[0], corners[k - 1], corners[k]}))
          fail_at(path_, 0, "a corner twice" + where, "different corners");
    }
  }

  const std::string& path_;
  const aiScene& scene_;
  CornerMesh corners_;
  std::int64_t count_ = 0;
};

}  // namespace

TriangleMesh read_by_assimp(const std::string& path, bool soup) {
  read_bytes(path, "a surface");  // says where there is none
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path, aiProcess_ValidateDataStructure);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    std::string fault = importer.GetErrorString();
    std::ranges::replace(fault, '\n', ' ');
    fail_at(path, 0, "what assimp refuses (" + fault + ")", "a surface in glTF or Collada");
  }
  return Surface(path, *scene, soup).read();
}

#else

TriangleMesh read_by_assimp(const std::string& path, bool) {
  fail_at(path, 0, "a glTF or Collada file", "an OBJ, STL or PLY file, since this program was built without assimp");
}

#endif

}  // namespace unibody
