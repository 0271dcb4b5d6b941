// Stands in for the header of DUNE, which Debian does not have: the part of it that docs/embedding/dune_task.cpp uses, with
// the types of DUNE 2022 and the fields of IMC 5.4. It declares, so that the task compiles; nothing runs.
#pragma once

#include <cstdint>
#include <string>

namespace DUNE
{
  namespace IMC
  {
    enum SpeedUnitsEnum { SUNITS_METERS_PS = 0, SUNITS_RPM = 1, SUNITS_PERCENTAGE = 2 };
    struct Message {};
    struct EstimatedState: Message { float theta, u, v, w, p, q, r; };
    struct DesiredPitch: Message { double value; };
    struct DesiredSpeed: Message { double value; uint8_t speed_units; };
    struct SetThrusterActuation: Message { uint8_t id; float value; };
  }
  namespace Time
  {
    struct Clock { static double get(void); };
  }
  namespace Tasks
  {
    struct Context {};
    class Periodic
    {
    public:
      Periodic(const std::string& name, Context& ctx);
      virtual ~Periodic(void);
      virtual void task(void) = 0;
    protected:
      template <typename M, typename T>
      void bind(T* task) { static_cast<void>(static_cast<void (T::*)(const M*)>(&T::consume)); static_cast<void>(task); }
      void dispatch(IMC::Message& message);
      void debug(const char* words, ...);
      void war(const char* words, ...);
      void err(const char* words, ...);
    };
  }
}

#define DUNE_NAMESPACES namespace DUNE; using namespace DUNE::Time
// DUNE's build defines it for each task, as what creates it.
#define DUNE_TASK
