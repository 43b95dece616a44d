// The calls, by number and by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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
inline constexpr std::size_t kCalls = static_cast<std::size_t>(Call::kUnknown) + 1;
/// Those of the contract, which are the first.
inline constexpr std::size_t kContractCalls = static_cast<std::size_t>(Call::kFindSurfaces) + 1;

/// Full name, e.g. "lucerna.v1.LightingService/SampleLi".
const char* name_of(Call call);

/// Number of gRPC's codes: OK is 0 and UNAUTHENTICATED is 16.
inline constexpr std::size_t kCodes = 17;
/// Name of a gRPC code, e.g. "INVALID_ARGUMENT".  "UNKNOWN" for numbers that are no code.
const char* code_name(int code);

}  // namespace lucerna::monitor
