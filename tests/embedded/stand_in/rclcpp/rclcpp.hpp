// Stands in for the header of ROS 2, which Debian does not have: the part of it that docs/embedding/ros2_node.cpp uses, with
// the types of rclcpp 16 (Humble). It declares, so that the node compiles; nothing runs.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

namespace rclcpp
{
struct QoS {
  QoS(size_t depth);  // NOLINT: as in rclcpp
};
struct SensorDataQoS : QoS {
  SensorDataQoS();
};
struct Logger {};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
};
template <typename M>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher<M>>;
  void publish(const M & message);
};
template <typename M>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription<M>>;
};
class Node {
public:
  explicit Node(const std::string & name);
  Logger get_logger() const;
  template <typename M>
  std::shared_ptr<Publisher<M>> create_publisher(const std::string & topic, const QoS & qos);
  template <typename M>
  std::shared_ptr<Subscription<M>> create_subscription(
    const std::string & topic, const QoS & qos, std::function<void(std::shared_ptr<M>)> callback);
  template <typename R, typename P>
  TimerBase::SharedPtr create_wall_timer(std::chrono::duration<R, P> period, std::function<void()> callback);
};
void init(int argc, char ** argv);
void spin(std::shared_ptr<Node> node);
void shutdown();
void log(const Logger & logger, const char * words);
}  // namespace rclcpp

#define RCLCPP_WARN(logger, words) rclcpp::log(logger, words)
#define RCLCPP_ERROR(logger, words) rclcpp::log(logger, words)
