// Stands in for the header of ROS 2, which Debian does not have: the part of it that docs/embedding/ros2_node.cpp uses,
// with the types of rclcpp 16 (Humble). A driver defines `spin`: it sets the clock, calls what the node has registered,
// and reads what was published and logged.
#pragma once

#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>

enum rcl_clock_type_t { RCL_STEADY_TIME };

namespace fake
{
inline double now;
inline std::map<std::string, std::function<void(double)>> subscriptions;
inline std::map<std::string, double> published;
inline std::function<void()> timer;
inline std::string words;  // logged last
inline int said;
}  // namespace fake

namespace rclcpp
{
struct QoS {
  QoS(size_t) {}  // NOLINT: as in rclcpp
};
struct SensorDataQoS : QoS {
  SensorDataQoS() : QoS(5) {}
};
struct Time {
  double seconds() const { return fake::now; }
};
struct Clock {
  explicit Clock(rcl_clock_type_t) {}
  Time now() const { return {}; }
};
struct Logger {};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
};
template <typename M>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher<M>>;
  void publish(const M & message) { fake::published[topic] = message.data; }
  std::string topic;
};
struct SubscriptionBase {
  using SharedPtr = std::shared_ptr<SubscriptionBase>;
};
template <typename M>
struct Subscription : SubscriptionBase {};
class Node {
public:
  explicit Node(const std::string &) {}
  Logger get_logger() const { return {}; }
  template <typename M>
  std::shared_ptr<Publisher<M>> create_publisher(const std::string & topic, const QoS &)
  {
    return std::make_shared<Publisher<M>>(Publisher<M>{topic});
  }
  template <typename M>
  std::shared_ptr<Subscription<M>> create_subscription(
    const std::string & topic, const QoS &, std::function<void(const M &)> callback)
  {
    fake::subscriptions[topic] = [callback](double data) {
      M message;
      message.data = static_cast<decltype(message.data)>(data);
      callback(message);
    };
    return std::make_shared<Subscription<M>>();
  }
  template <typename R, typename P>
  TimerBase::SharedPtr create_wall_timer(std::chrono::duration<R, P>, std::function<void()> callback)
  {
    fake::timer = callback;
    return std::make_shared<TimerBase>();
  }
};
inline void init(int, char **) {}
void spin(std::shared_ptr<Node> node);
inline void shutdown() {}
[[gnu::format(printf, 2, 3)]] inline void log(const Logger &, const char * format, ...)
{
  char line[200];
  va_list numbers;
  va_start(numbers, format);
  std::vsnprintf(line, sizeof line, format, numbers);
  va_end(numbers);
  fake::words = line;
  fake::said++;
}
}  // namespace rclcpp

#define RCLCPP_WARN(logger, ...) rclcpp::log(logger, __VA_ARGS__)
