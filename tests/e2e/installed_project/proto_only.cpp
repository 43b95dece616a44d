// Messages, stubs, the standard protos and the arithmetic of tiles, from lucerna::proto alone.
#include "google/rpc/error_details.pb.h"
#include "grpc/health/v1/health.pb.h"
#include "lucerna/proto/tile_statistics.h"
#include "lucerna/v1/lighting.grpc.pb.h"

int main() {
  const lucerna::BlockStatistics a{.sum = 1, .deviation = 0};
  const lucerna::BlockStatistics b{.sum = 3, .deviation = 0};
  // Two values 1 and 3: sum 4, squared deviation from their mean 1 + 1.
  const lucerna::BlockStatistics both = lucerna::merge(a, 1, b, 1);
  google::rpc::BadRequest details;
  grpc::health::v1::HealthCheckRequest health;
  const bool named = lucerna::v1::LightingService::service_full_name() ==
                     std::string("lucerna.v1.LightingService");
  const bool right = both.sum == 4 && both.deviation == 2 && named && details.ByteSizeLong() == 0 &&
                     health.service().empty();
  return right ? 0 : 1;
}
