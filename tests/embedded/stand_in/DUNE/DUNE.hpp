// Stands in for the header of DUNE, which Debian does not have: the part of it that docs/embedding/dune_task.cpp uses,
// with the types of DUNE 2022 and the fields of IMC 5.4. A driver sets the clock, calls what the task has bound, and
// reads what was dispatched and reported.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace fake
{
  constexpr uint16_t system_id = 1;
  inline double now;
  template <typename M> inline std::function<void(const M*)> consumer;
  //! The value that each thruster was sent last.
  inline std::map<int, double> dispatched;
  inline int state, said;
  inline std::string words;
}

namespace DUNE
{
  namespace IMC
  {
    enum SpeedUnitsEnum { SUNITS_METERS_PS = 0, SUNITS_RPM = 1, SUNITS_PERCENTAGE = 2 };
    enum CLoopsMask { CL_PITCH = 0x20, CL_SPEED = 0x80 };
    struct Message
    {
      virtual ~Message(void) {}
      uint16_t getSource(void) const { return m_source; }
      void setSource(uint16_t source) { m_source = source; }
    private:
      uint16_t m_source = fake::system_id;
    };
    struct EstimatedState: Message { float theta, u, v, w, p, q, r; };
    struct WaterVelocity: Message
    {
      enum ValidityBits { VAL_VEL_X = 0x01, VAL_VEL_Y = 0x02, VAL_VEL_Z = 0x04 };
      uint8_t validity;
      double x, y, z;
    };
    struct DesiredPitch: Message { double value; };
    struct DesiredSpeed: Message { double value; uint8_t speed_units; };
    struct SetThrusterActuation: Message { uint8_t id; float value; };
    struct ControlLoops: Message
    {
      enum EnableEnum { CL_DISABLE = 0, CL_ENABLE = 1 };
      uint8_t enable;
      uint32_t mask, scope_ref;
    };
    struct EntityState: Message { enum StateEnum { ESTA_BOOT, ESTA_NORMAL, ESTA_FAULT, ESTA_ERROR, ESTA_FAILURE }; };
  }
  namespace Time
  {
    struct Clock { static double get(void) { return fake::now; } };
  }
  namespace Tasks
  {
    struct Context {};
    class Periodic
    {
    public:
      Periodic(const std::string&, Context&): m_active(false) {}
      virtual ~Periodic(void) {}
      virtual void task(void) = 0;
    protected:
      template <typename M, typename T>
      void bind(T* task) { fake::consumer<M> = [task](const M* message) { task->consume(message); }; }
      void dispatch(IMC::Message& message)
      {
        if (const auto* act = dynamic_cast<IMC::SetThrusterActuation*>(&message))
          fake::dispatched[act->id] = act->value;
      }
      unsigned getSystemId(void) const { return fake::system_id; }
      bool isActive(void) const { return m_active; }
      void requestActivation(void) { m_active = true; }
      void requestDeactivation(void) { m_active = false; }
      void setEntityState(IMC::EntityState::StateEnum state, const std::string& description)
      {
        fake::state = state;
        fake::words = description;
        fake::said++;
      }
    private:
      bool m_active;
    };
  }
}

#define DUNE_NAMESPACES namespace DUNE; using namespace DUNE::Time
// DUNE's build defines it for each task, as what creates it.
#define DUNE_TASK \
  DUNE::Tasks::Periodic* create(const std::string& name, DUNE::Tasks::Context& context) \
  { return new Control::AUV::Squid::Task(name, context); }
