//! A gain-scheduled controller at run time: loads a frozen LFT design and steps it
