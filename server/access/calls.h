// The role that each call needs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/monitor/call_names.h"

#include "server/monitor/call_names.h"

namespace lucerna::access {

/// What a caller may do.  No role includes another.
enum class Role : std::uint8_t { kQuery, kLoad, kAdmin };
inline constexpr std::array kRoleNames{"query", "load", "admin"};  // in the order of Role
constexpr const char* name_of(Role role) { return kRoleNames[static_cast<std::size_t>(role)]; }

using monitor::Call;

struct CallEntry {
  Call call;
  Role role;
};

/// Every call, in the order of Call.
inline constexpr std::array kCalls{
    CallEntry{Call::kFindMissingAssets, "SceneService/FindMissingAssets", Role::kLoad},
    CallEntry{Call::kUploadAsset, "SceneService/UploadAsset", Role::kLoad},
    CallEntry{Call::kLoadScene, "SceneService/LoadScene", Role::kLoad},
    CallEntry{Call::kGetScene, "SceneService/GetScene", Role::kQuery},
    CallEntry{Call::kListScenes, "SceneService/ListScenes", Role::kQuery},
    CallEntry{Call::kListAvailableScenes, "SceneService/ListAvailableScenes", Role::kLoad},
    CallEntry{Call::kListLights, "SceneService/ListLights", Role::kQuery},
    CallEntry{Call::kEditLights, "SceneService/EditLights", Role::kLoad},
    CallEntry{Call::kRenewLease, "SceneService/RenewLease", Role::kLoad},
    CallEntry{Call::kReleaseScene, "SceneService/ReleaseScene", Role::kLoad},
    CallEntry{Call::kSampleLi, "LightingService/SampleLi", Role::kQuery},
    CallEntry{Call::kPdfLi, "LightingService/PdfLi", Role::kQuery},
    CallEntry{Call::kSampleLe, "LightingService/SampleLe", Role::kQuery},
    CallEntry{Call::kPdfLe, "LightingService/PdfLe", Role::kQuery},
    CallEntry{Call::kLe, "LightingService/Le", Role::kQuery},
    CallEntry{Call::kEstimatePower, "LightingService/EstimatePower", Role::kQuery},
    CallEntry{Call::kTestVisibility, "LightingService/TestVisibility", Role::kQuery},
    CallEntry{Call::kEstimateIrradiance, "LightingService/EstimateIrradiance", Role::kQuery},
    CallEntry{Call::kRenderTile, "RenderService/RenderTile", Role::kQuery},
    CallEntry{Call::kRenderImage, "RenderService/RenderImage", Role::kQuery},
    CallEntry{Call::kGetServerInfo, "AdminService/GetServerInfo", Role::kQuery},
    CallEntry{Call::kGetStats, "AdminService/GetStats", Role::kAdmin},
    CallEntry{Call::kListLeases, "AdminService/ListLeases", Role::kLoad},
};
constexpr Role role_of(Call call) { return kCallRoles[static_cast<std::size_t>(call)].role; }
static_assert(
    [] {
      for (std::size_t i = 0; i < kCalls.size(); ++i)
        if (kCalls[i].call != static_cast<Call>(i)) return false;
      return kCalls.size() == monitor::kCalls;
    }(),
    "kCallRoles has each call once, in the order of Call");

}  // namespace lucerna::access
