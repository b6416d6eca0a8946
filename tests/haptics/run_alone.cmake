# Sessions in real time between two threads: beside another test on few cores they miss their ticks.
foreach(name a_hand_feels_over_loopback two_hands_feel_at_once a_bad_line_gives_no_spikes
    a_cut_line_fades_the_force_on_both_sides_and_recovers)
  set_tests_properties(haptics.UdpDevice.${name} PROPERTIES RUN_SERIAL TRUE)
endforeach()
