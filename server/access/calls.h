// The role that each call needs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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

/// Every call of the contract, in the order of Call.
inline constexpr std::array kCallRoles{
    CallEntry{Call::kFindMissingAssets, Role::kLoad},
    CallEntry{Call::kUploadAsset, Role::kLoad},
    CallEntry{Call::kLoadScene, Role::kLoad},
    CallEntry{Call::kGetScene, Role::kQuery},
    CallEntry{Call::kListScenes, Role::kQuery},
    CallEntry{Call::kListAvailableScenes, Role::kLoad},
    CallEntry{Call::kListLights, Role::kQuery},
    CallEntry{Call::kEditLights, Role::kLoad},
    CallEntry{Call::kRenewLease, Role::kLoad},
    CallEntry{Call::kReleaseScene, Role::kLoad},
    CallEntry{Call::kSampleLi, Role::kQuery},
    CallEntry{Call::kPdfLi, Role::kQuery},
    CallEntry{Call::kSampleLe, Role::kQuery},
    CallEntry{Call::kPdfLe, Role::kQuery},
    CallEntry{Call::kLe, Role::kQuery},
    CallEntry{Call::kEstimatePower, Role::kQuery},
    CallEntry{Call::kTestVisibility, Role::kQuery},
    CallEntry{Call::kEstimateIrradiance, Role::kQuery},
    CallEntry{Call::kRenderTile, Role::kQuery},
    CallEntry{Call::kRenderImage, Role::kQuery},
    CallEntry{Call::kGetServerInfo, Role::kQuery},
    CallEntry{Call::kGetStats, Role::kAdmin},
    CallEntry{Call::kListLeases, Role::kLoad},
    CallEntry{Call::kFindSurfaces, Role::kQuery},
};
constexpr Role role_of(Call call) { return kCallRoles[static_cast<std::size_t>(call)].role; }
static_assert(
    [] {
      for (std::size_t i = 0; i < kCallRoles.size(); ++i)
        if (kCallRoles[i].call != static_cast<Call>(i)) return false;
      return kCallRoles.size() == monitor::kContractCalls;
    }(),
    "kCallRoles has each call once, in the order of Call");

}  // namespace lucerna::access
