// Statistics in the data model of Prometheus.  docs/monitoring.md describes every metric.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "lucerna/v1/admin.pb.h"

namespace lucerna::monitor {

/// `stats`: with every call, also those that nobody made.
std::vector<prometheus::MetricFamily> metric_families(const v1::GetStatsResponse& stats,
                                                      const v1::GetServerInfoResponse& info);

}  // namespace lucerna::monitor
