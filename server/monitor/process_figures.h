// What the operating system reports of this process.
#pragma once

#include "lucerna/v1/admin.pb.h"

namespace lucerna::monitor {

/// Reads /proc/self.  A figure that cannot be read is 0.
v1::ProcessStats process_figures();

}  // namespace lucerna::monitor
