#include "server/monitor/call_names.h"

namespace lucerna::monitor {
namespace {

constexpr std::array<const char*, kCalls> kNames{
    "lucerna.v1.SceneService/FindMissingAssets",
    "lucerna.v1.SceneService/UploadAsset",
    "lucerna.v1.SceneService/LoadScene",
    "lucerna.v1.SceneService/GetScene",
    "lucerna.v1.SceneService/ListScenes",
    "lucerna.v1.SceneService/ListAvailableScenes",
    "lucerna.v1.SceneService/ListLights",
    "lucerna.v1.SceneService/EditLights",
    "lucerna.v1.SceneService/RenewLease",
    "lucerna.v1.SceneService/ReleaseScene",
    "lucerna.v1.LightingService/SampleLi",
    "lucerna.v1.LightingService/PdfLi",
    "lucerna.v1.LightingService/SampleLe",
    "lucerna.v1.LightingService/PdfLe",
    "lucerna.v1.LightingService/Le",
    "lucerna.v1.LightingService/EstimatePower",
    "lucerna.v1.LightingService/TestVisibility",
    "lucerna.v1.LightingService/EstimateIrradiance",
    "lucerna.v1.RenderService/RenderTile",
    "lucerna.v1.RenderService/RenderImage",
    "lucerna.v1.AdminService/GetServerInfo",
    "lucerna.v1.AdminService/GetStats",
    "lucerna.v1.AdminService/ListLeases",
    "lucerna.v1.RenderService/FindSurfaces",
    "grpc.health.v1.Health/Check",
    "grpc.health.v1.Health/Watch",
    "grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
    "grpc/unknown",
};

// In the order of their numbers.
constexpr std::array<const char*, kCodes> kCodeNames{
    "OK",
    "CANCELLED",
    "UNKNOWN",
    "INVALID_ARGUMENT",
    "DEADLINE_EXCEEDED",
    "NOT_FOUND",
    "ALREADY_EXISTS",
    "PERMISSION_DENIED",
    "RESOURCE_EXHAUSTED",
    "FAILED_PRECONDITION",
    "ABORTED",
    "OUT_OF_RANGE",
    "UNIMPLEMENTED",
    "INTERNAL",
    "UNAVAILABLE",
    "DATA_LOSS",
    "UNAUTHENTICATED",
};

}  // namespace

const char* name_of(Call call) { return kNames[static_cast<std::size_t>(call)]; }

const char* code_name(int code) {
  return code >= 0 && static_cast<std::size_t>(code) < kCodes ? kCodeNames[code] : "UNKNOWN";
}

}  // namespace lucerna::monitor
