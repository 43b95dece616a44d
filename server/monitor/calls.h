// The calls: their names, and the role that each needs.
#pragma once

#include <absl/status/status.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace lucerna::monitor {

enum class Call : std::uint8_t {
  kFindMissingAssets,
  kUploadAsset,
  kLoadScene,
  kGetScene,
  kListScenes,
  kListAvailableScenes,
  kListLights,
  kEditLights,
  kRenewLease,
  kReleaseScene,
  kSampleLi,
  kPdfLi,
  kSampleLe,
  kPdfLe,
  kLe,
  kEstimatePower,
  kTestVisibility,
  kEstimateIrradiance,
  kRenderTile,
  kRenderImage,
  kGetServerInfo,
  kGetStats,
  kListLeases,
  kFindSurfaces,
  // Calls that gRPC answers.
  kHealthCheck,
  kHealthWatch,
  kReflection,
  kUnknown,  ///< every call that does not exist
};

/// What a caller may do.  No role includes another.
enum class Role : std::uint8_t { kQuery, kLoad, kAdmin };
inline constexpr std::array kRoleNames{"query", "load", "admin"};  // in the order of Role
constexpr const char* name_of(Role role) { return kRoleNames[static_cast<std::size_t>(role)]; }

struct CallEntry {
  Call call;
  const char* name;          ///< full, e.g. "lucerna.v1.LightingService/SampleLi"
  Role role = Role::kAdmin;  ///< of calls of the contract
};

/// Every call, in the order of Call.  Those of the contract are the first.
inline constexpr CallEntry kCallTable[] = {
    {Call::kFindMissingAssets, "lucerna.v1.SceneService/FindMissingAssets", Role::kLoad},
    {Call::kUploadAsset, "lucerna.v1.SceneService/UploadAsset", Role::kLoad},
    {Call::kLoadScene, "lucerna.v1.SceneService/LoadScene", Role::kLoad},
    {Call::kGetScene, "lucerna.v1.SceneService/GetScene", Role::kQuery},
    {Call::kListScenes, "lucerna.v1.SceneService/ListScenes", Role::kQuery},
    {Call::kListAvailableScenes, "lucerna.v1.SceneService/ListAvailableScenes", Role::kLoad},
    {Call::kListLights, "lucerna.v1.SceneService/ListLights", Role::kQuery},
    {Call::kEditLights, "lucerna.v1.SceneService/EditLights", Role::kLoad},
    {Call::kRenewLease, "lucerna.v1.SceneService/RenewLease", Role::kLoad},
    {Call::kReleaseScene, "lucerna.v1.SceneService/ReleaseScene", Role::kLoad},
    {Call::kSampleLi, "lucerna.v1.LightingService/SampleLi", Role::kQuery},
    {Call::kPdfLi, "lucerna.v1.LightingService/PdfLi", Role::kQuery},
    {Call::kSampleLe, "lucerna.v1.LightingService/SampleLe", Role::kQuery},
    {Call::kPdfLe, "lucerna.v1.LightingService/PdfLe", Role::kQuery},
    {Call::kLe, "lucerna.v1.LightingService/Le", Role::kQuery},
    {Call::kEstimatePower, "lucerna.v1.LightingService/EstimatePower", Role::kQuery},
    {Call::kTestVisibility, "lucerna.v1.LightingService/TestVisibility", Role::kQuery},
    {Call::kEstimateIrradiance, "lucerna.v1.LightingService/EstimateIrradiance", Role::kQuery},
    {Call::kRenderTile, "lucerna.v1.RenderService/RenderTile", Role::kQuery},
    {Call::kRenderImage, "lucerna.v1.RenderService/RenderImage", Role::kQuery},
    {Call::kGetServerInfo, "lucerna.v1.AdminService/GetServerInfo", Role::kQuery},
    {Call::kGetStats, "lucerna.v1.AdminService/GetStats", Role::kAdmin},
    {Call::kListLeases, "lucerna.v1.AdminService/ListLeases", Role::kLoad},
    {Call::kFindSurfaces, "lucerna.v1.RenderService/FindSurfaces", Role::kQuery},
    {Call::kHealthCheck, "grpc.health.v1.Health/Check"},
    {Call::kHealthWatch, "grpc.health.v1.Health/Watch"},
    {Call::kReflection, "grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"},
    {Call::kUnknown, "grpc/unknown"},
};
inline constexpr std::size_t kCalls = std::size(kCallTable);
inline constexpr std::size_t kContractCalls = static_cast<std::size_t>(Call::kFindSurfaces) + 1;
static_assert(
    [] {
      for (std::size_t i = 0; i < kCalls; ++i)
        if (kCallTable[i].call != static_cast<Call>(i)) return false;
      return kCallTable[kCalls - 1].call == Call::kUnknown;
    }(),
    "kCallTable has each call once, in the order of Call");

constexpr const char* name_of(Call call) { return kCallTable[static_cast<std::size_t>(call)].name; }
constexpr Role role_of(Call call) { return kCallTable[static_cast<std::size_t>(call)].role; }

/// Number of gRPC's codes: OK is 0 and UNAUTHENTICATED is 16.
inline constexpr std::size_t kCodes = 17;
/// Name of a gRPC code, e.g. "INVALID_ARGUMENT".  "UNKNOWN" for numbers that are no code.
inline std::string code_name(int code) {
  const std::string name = absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
  return name.empty() ? "UNKNOWN" : name;
}

}  // namespace lucerna::monitor
