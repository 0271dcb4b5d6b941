// Stands in for the message of ROS 2; see rclcpp.hpp.
#pragma once

#include <memory>

namespace std_msgs::msg
{
struct Float64 {
  using SharedPtr = std::shared_ptr<Float64>;
  double data;
};
}  // namespace std_msgs::msg
