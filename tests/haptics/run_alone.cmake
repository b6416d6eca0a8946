# Sessions in real time between two threads: beside another test on few cores they miss their ticks.
foreach(name AHandFeelsTheSurfaceOverLoopback TwoHandsFeelAtOnce ABadLineCausesNoForceSpikes
    ACutLineFadesTheForceOnBothSidesAndRecovers)
  set_tests_properties(haptics.UdpSession.${name} PROPERTIES RUN_SERIAL TRUE)
endforeach()
