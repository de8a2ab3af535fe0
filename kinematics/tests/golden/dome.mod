MODULE dome
  PERS tooldata nozzle:=[FALSE,[[300,60.5,220],[0.52666812,0.12548778,-0.08365852,0.83658518]],[1.25,[0,3.5,40],[1,0,0,0],0,0,0]];
  PERS wobjdata part:=[TRUE,TRUE,"",[[0,0,45],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PROC main()
    ConfJ\On;
    ConfL\On;
    Load\Dynamic,"HOME:"\File:="dome_001.mod";
    %"dome_001"%;
    UnLoad "HOME:"\File:="dome_001.mod";
  ENDPROC
ENDMODULE
