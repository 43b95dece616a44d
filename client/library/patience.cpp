#include "client/library/patience.h"

#include <future>
#include <thread>
#include <utility>

namespace lucerna::client {

absl::StatusOr<std::vector<std::string>> look_up_within(std::chrono::seconds patience,
                                                        const std::string& name, LookUp look_up) {
  // std::async does not work here: the destructor of its future waits for the thread.
  std::packaged_task<absl::StatusOr<std::vector<std::string>>()> task(std::move(look_up));
  auto answer = task.get_future();
  std::thread(std::move(task)).detach();
  if (answer.wait_for(patience) == std::future_status::ready) return answer.get();
  return absl::UnavailableError("the name " + name + " is still being looked up after " +
                                std::to_string(patience.count()) + " s");
}

}  // namespace lucerna::client
