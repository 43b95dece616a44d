// Figures in the data model of Prometheus.  docs/monitoring.md describes every metric.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "server/monitor/figures.h"

namespace lucerna::monitor {

std::vector<prometheus::MetricFamily> metric_families(const Figures& figures);

}  // namespace lucerna::monitor
