// Stands in for the message of ROS 2; see rclcpp.hpp.
#pragma once

#include <cstdint>

namespace std_msgs::msg
{
struct UInt32 {
  uint32_t data;
};
}  // namespace std_msgs::msg
