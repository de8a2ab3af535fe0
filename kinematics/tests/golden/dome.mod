MODULE dome
  ! 5 s of motion at the speeds of its moves, without accelerations and loading
  PERS tooldata nozzle:=[FALSE,[[300,60.5,220],[0.52666812,0.12548778,-0.08365852,0.83658518]],[1.25,[0,3.5,40],[1,0,0,0],0,0,0]];
  PERS wobjdata part:=[TRUE,TRUE,"",[[0,0,45],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PERS loaddata dome_load:=[0.4,[1,-2,30.5],[1,0,0,0],0,0,0];
  PROC main()
    dome_off;
    ConfJ\On;
    ConfL\On;
    GripLoad dome_load;
    Load\Dynamic,"HOME:"\File:="dome_001.mod";
    %"dome_001_run"%;
    UnLoad "HOME:"\File:="dome_001.mod";
    dome_off;
  ERROR
    dome_off;
    RAISE;
  ENDPROC
  PROC dome_off()
    SetDO doExtruder,0;
  ENDPROC
ENDMODULE
